/* Tests trackers with a folder: resuming, one writer and many readers, changes of grid and clock, formats, kill -9. */
#include <signal.h>
#include <sys/wait.h>

#include "track_folder.h"

/* promise: committed-frames-survive-kills */
TEST_IN_FOLDER(committed_frames_are_resumed) {
    toliman_track_options options = filled_folder();
    for (int time = 0; time < 2; time++) {
        toliman_track *track = make_track(&options);
        assert_filled(track, &options);
        toliman_track_destroy(track);
    }
    /* Known frames are duplicates, new ones are accepted; uncommitted ones are lost. */
    toliman_track *track = make_track(&options);
    assert_int_equal(push_number(track, 60), TOLIMAN_TRACK_VERDICT_DUPLICATE);
    assert_int_equal(push_number(track, 10), TOLIMAN_TRACK_VERDICT_QUARANTINED);
    push_range(track, 61, 70);
    toliman_track_info info = info_of(track);
    assert_int_equal(info.records, FILLED_LINES + 10);
    assert_int_equal(info.committed, FILLED_LINES);
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_filled(track, &options);
    toliman_track_destroy(track);
    /* A folder with more frames than the capacity. */
    options.ledger.capacity = 59;
    assert_refused(toliman_track_create(&options, &track), TOLIMAN_E_CAPACITY, "");
}

/* promise: folders-have-one-writer */
TEST_IN_FOLDER(one_writer_and_many_readers) {
    toliman_track_options options = small_options(folder), looking;
    toliman_track *writer = make_track(&options), *none = NULL;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_STATE, folder);
    push_range(writer, 1, 64);
    push_range(writer, 65, 70); /* not yet committed */
    looking = (toliman_track_options)TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_load_options(folder, &looking));
    assert_true(looking.estimator.sigma == SIGMA && looking.limits.value == VALUE_LIMIT && looking.estimator.id == 77);
    assert_true(looking.frames.rows == SIDE && looking.frames.image_cols == SIDE && looking.frames.bin == 1 &&
                looking.frames.bit_depth == 12);
    assert_true(looking.grid.nf == FREQUENCIES && looking.grid.f0 == options.grid.f0 && looking.grid.unit_ns == DAY_NS);
    looking.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *readers[3];
    for (int i = 0; i < 3; i++) {
        looking.grid.nf = i < 2 ? looking.grid.nf : 0;
        readers[i] = make_track(&looking);
        assert_holds(readers[i], &options, 1, 64);
        assert_refused(toliman_track_save(readers[i]), TOLIMAN_E_STATE, folder);
        assert_refused(toliman_track_commit(readers[i]), TOLIMAN_E_STATE, folder);
        assert_refused(toliman_track_merge(readers[i], folder, 0, NULL), TOLIMAN_E_STATE, folder);
        small_frame frame;
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        size_t done;
        make_frame(&frame, 99);
        assert_refused(toliman_track_push(readers[i], &frame.frame, 1, &outcome, &done), TOLIMAN_E_STATE, folder);
    }
    push_range(writer, 71, 80);
    assert_ok(toliman_track_save(writer));
    toliman_track_destroy(writer);
    writer = make_track(&options); /* while readers are open */
    assert_holds(writer, &options, 1, 80);
    for (int i = 0; i < 3; i++) {
        assert_holds(readers[i], &options, 1, 64);
        toliman_track_destroy(readers[i]);
    }
    toliman_track_destroy(writer);
}

/* A new clock changes every time, a new grid the frequencies: the result is as if all frames arrived under them. */
/* promise: rebuilds-equal-new-folders */
TEST_IN_FOLDER(another_grid_and_clock_without_frames) {
    toliman_track_options options = filled_folder();
    const int64_t clock[] = {0, 5000, 30 * DAY_NS, 31 * DAY_NS, 50 * DAY_NS, 50 * DAY_NS + 77};
    toliman_track_options other = options;
    other.clock.pairs = clock;
    other.clock.count = 3;
    toliman_track *track = NULL;
    assert_refused(toliman_track_create(&other, &track), TOLIMAN_E_MISMATCH, setup);
    other.grid.nf = 30;
    other.grid.df = 0.001;
    other.grid.unit_ns = 3600e9;
    other.grid.flags = TOLIMAN_PERIOD_FIXED_MEAN | TOLIMAN_PERIOD_DOUBLE_LIMB;
    assert_refused(toliman_track_create(&other, &track), TOLIMAN_E_MISMATCH, setup);
    other.flags = TOLIMAN_TRACK_REBUILD;
    toliman_track *rebuilt = make_track(&other);

    toliman_track_options fresh = other;
    fresh.folder = NULL;
    fresh.flags = 0;
    toliman_track *expected = make_track(&fresh);
    for (int64_t id = 1; id <= 60; id++)
        if (id != 10 && id != 20 && id != 50)
            push_number(expected, id);
    assert_same_periods(period_of(rebuilt), period_of(expected));
    assert_int_equal(info_of(rebuilt).repeated, FILLED_REPEATS);
    push_range(rebuilt, 61, 62);
    push_range(expected, 61, 62);
    assert_ok(toliman_track_commit(rebuilt));
    toliman_track_destroy(rebuilt);
    /* Options without grid and clock use the folder's new ones, also for a reader and for records after the
     * checkpoint. */
    options.grid.nf = 0;
    for (int reading = 0; reading < 2; reading++) {
        options.flags = reading ? TOLIMAN_TRACK_READ_ONLY : 0;
        track = make_track(&options);
        assert_same_periods(period_of(track), period_of(expected));
        toliman_track_destroy(track);
    }
    options.flags = TOLIMAN_TRACK_REBUILD; /* another rebuild keeps them, too */
    track = make_track(&options);
    assert_same_periods(period_of(track), period_of(expected));
    toliman_track_destroy(track), toliman_track_destroy(expected);
}

TEST_IN_FOLDER(records_can_be_read) {
    const toliman_track_options options = filled_folder();
    toliman_track *track = make_track(&options);
    static toliman_track_record lines[100];
    small_frame frame;
    size_t done = 0;
    make_frame(&frame, 70);
    frame.pixels[5] = 5000;
    frame.frame.dropped = 3;
    push_one(track, &frame.frame);
    push_number(track, 71); /* these wait in the group */
    lines[0].struct_size = sizeof *lines;
    assert_ok(toliman_track_get_records(track, 0, 100, lines, &done));
    assert_int_equal(done, FILLED_LINES + 2);
    int64_t accepted = 0, outlier = 0, quarantined = 0, counts = 0;
    for (size_t i = 0; i < done; i++) {
        assert_int_equal(lines[i].struct_size, sizeof *lines);
        accepted += lines[i].verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED;
        outlier += lines[i].verdict == TOLIMAN_TRACK_VERDICT_OUTLIER;
        quarantined += lines[i].verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED;
        counts += lines[i].verdict == TOLIMAN_TRACK_VERDICT_MERGED;
        if (lines[i].verdict > TOLIMAN_TRACK_VERDICT_ACCEPTED)
            continue;
        make_frame(&frame, lines[i].frame_id);
        assert_true(lines[i].value == value_of_frame(&frame) && lines[i].sigma == SIGMA);
        assert_true(lines[i].tai_ns == frame.frame.camera_ns && lines[i].camera_ns == frame.frame.camera_ns);
    }
    const toliman_track_info info = info_of(track);
    assert_int_equal(accepted, info.accepted);
    assert_int_equal(outlier, info.outlier);
    assert_int_equal(quarantined, 2 * info.quarantined);
    assert_int_equal(counts, FILLED_LINES - 63);
    assert_int_equal(lines[FILLED_LINES].verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
    assert_int_equal(lines[FILLED_LINES].reason, TOLIMAN_TRACK_REASON_OVER_RANGE);
    assert_int_equal(lines[FILLED_LINES].dropped, 3);
    assert_int_equal(lines[FILLED_LINES + 1].frame_id, 71);
    toliman_track_record last[3] = {{.struct_size = sizeof *last}};
    assert_ok(toliman_track_get_records(track, info.records - 3, 3, last, &done));
    assert_int_equal(done, 3);
    assert_memory_equal(last, lines + FILLED_LINES - 1, sizeof last);
    for (int64_t beyond = info.records; beyond < INT64_MAX / 4; beyond *= 3) {
        assert_ok(toliman_track_get_records(track, beyond, 3, last, &done));
        assert_int_equal(done, 0);
    }
    assert_refused(toliman_track_get_records(track, -1, 3, last, &done), TOLIMAN_E_RANGE, "first");
    toliman_track_destroy(track);
    toliman_track_options elsewhere = small_options(NULL);
    track = make_track(&elsewhere);
    push_range(track, 1, 9);
    assert_ok(toliman_track_get_records(track, 2, 100, lines, &done));
    assert_int_equal(done, 7);
    assert_int_equal(lines[0].frame_id, 3);
    toliman_track_destroy(track);
}

TEST_IN_FOLDER(bad_options_leave_no_folder) {
    char path[300];
    snprintf(path, sizeof path, "%s/none", folder);
    const int64_t falling[4] = {0, 0, 5, -5};
    toliman_track *none = NULL;
    for (int trial = 0; trial < 5; trial++) {
        toliman_track_options options = small_options(path);
        options.grid.df = trial == 0 ? -1 : options.grid.df;
        options.ledger.capacity = trial == 1 ? -1 : options.ledger.capacity;
        options.ledger.group = trial == 2 ? 65537 : options.ledger.group;
        options.clock.pairs = trial == 3 ? falling : NULL;
        options.clock.count = trial == 3 ? 2 : 0;
        options.frames.bin = trial == 4 ? 9 : 0;
        assert_int_equal(toliman_track_create(&options, &none), TOLIMAN_E_ARGUMENT);
        assert_int_equal(access(path, F_OK), -1);
    }
    assert_null(none);
}

static uint64_t fnv1a(const char *text, size_t size) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ (unsigned char)text[i]) * 0x100000001b3u;
    return hash;
}

/* Offsets as in tools/docs/formats.md; also with another clock, and after a merge. */
TEST_IN_FOLDER(ledger_matches_its_format) {
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_frame(&frame, 5);
    frame.frame.dropped = 0xabcdef; /* 24 bits: in three fields */
    push_one(track, &frame.frame);
    frame.pixels[1]++;
    push_one(track, &frame.frame);
    push_number(track, 7);
    make_frame(&frame, 8);
    frame.pixels[2] = 4096;
    push_one(track, &frame.frame);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);

    unsigned char bytes[HEADER + 4 * LINE];
    read_at(ledger, 0, bytes, sizeof bytes);
    assert_int_equal(size_of(ledger), sizeof bytes);
    assert_memory_equal(bytes, "TLML\2\0\0\0", 8);
    static const uint64_t geometry[] = {SIDE, SIDE, 0, 0, SIDE, SIDE, 1, 12, PIXELS};
    assert_memory_equal(bytes + 16, geometry, sizeof geometry);
    assert_true(double_at(ledger, 88) == SIGMA && double_at(ledger, 96) == VALUE_LIMIT);
    assert_int_equal(number_at(ledger, 104, 8), 77);
    assert_int_equal(number_at(ledger, 112, 4), COLUMNS);
    assert_int_equal(number_at(ledger, 116, 4), LINE);
    static const char names[COLUMNS][56] = {"chi_square",       "exposure_s", "shift_s",   "window_row",
                                            "window_col",       "flags",      "intervals", "chi_square_sigma",
                                            "largest_residual", "bad_pixels"};
    for (int i = 0; i < COLUMNS; i++) {
        assert_memory_equal(bytes + 120 + 64 * i, names[i], sizeof names[i]);
        assert_int_equal(number_at(ledger, 120 + 64 * i + 56, 4), i < 3 || i == 7 || i == 8 ? 0 : 1); /* f64, i64 */
        assert_int_equal(number_at(ledger, 120 + 64 * i + 60, 4), 1); /* of the library */
    }
    uint32_t chain = crc32(0, bytes, HEADER - 4);
    assert_int_equal(number_at(ledger, HEADER - 4, 4), chain);
    static const int kinds[] = {1, 3, 2, 4}, reasons[] = {0, 0, 0, 2}, ids[] = {5, 5, 7, 8};
    for (int line = 0; line < 4; line++) {
        const off_t at = HEADER + line * LINE;
        make_frame(&frame, ids[line]);
        frame.pixels[1] = (uint16_t)(frame.pixels[1] + (line == 1));
        frame.pixels[2] = line == 3 ? 4096 : frame.pixels[2];
        const uint64_t dropped = line < 2 ? 0xabcdef : 0;
        const uint64_t fields[] = {(uint64_t)frame.frame.camera_ns, dropped, 0, SIDE, SIDE, 1 /* u16 */, 0, 0, 0, 0};
        const uint32_t content = crc32(crc32(0, fields, sizeof fields), frame.pixels, sizeof frame.pixels);
        assert_true(number_at(ledger, at, 8) == fnv1a("pass-1\0core", 11));
        assert_int_equal(number_at(ledger, at + 8, 4), content);
        assert_int_equal(number_at(ledger, at + 12, 8), ids[line]);
        assert_int_equal(number_at(ledger, at + 20, 8), frame.frame.camera_ns);
        assert_int_equal(number_at(ledger, at + 28, 8), line == 3 ? 0 : frame.frame.camera_ns);
        assert_true(double_at(ledger, at + 36) == (line == 3 ? 0 : value_of_frame(&frame)));
        assert_true(double_at(ledger, at + 44) == SIGMA);
        assert_int_equal(number_at(ledger, at + 52, 1), kinds[line] | (line < 2 ? 0xb0 : 0));
        assert_int_equal(number_at(ledger, at + 53, 1), reasons[line] | (line < 2 ? 0xa0 : 0));
        assert_int_equal(number_at(ledger, at + 54, 2), dropped & 0xffff);
        assert_true(isnan(double_at(ledger, at + 56)));
        for (int i = 1; i < COLUMNS; i++)
            assert_true(i == 7 || i == 8 ? isnan(double_at(ledger, at + 56 + 8 * i))
                                         : number_at(ledger, at + 56 + 8 * i, 8) == 0);
        assert_int_equal(number_at(ledger, at + LINE - 8, 4), 0);
        chain = crc32(chain, bytes + at, LINE - 4);
        assert_int_equal(number_at(ledger, at + LINE - 4, 4), chain);
    }
    char source[300];
    snprintf(source, sizeof source, "%s-source", folder);
    assert_int_equal(rename(folder, source), 0);
    const int64_t clock[] = {0, 1000};
    options.clock.pairs = clock;
    options.clock.count = 1;
    track = make_track(&options);
    assert_ok(toliman_track_merge(track, source, 0, NULL));
    assert_int_equal(number_at(ledger, HEADER + 2 * LINE + 28, 8) - number_at(ledger, HEADER + 2 * LINE + 20, 8), 1000);
    toliman_track_destroy(track);
    remove_folder(source);
}

/* Records wait for their group at most a second, as long as frames arrive. */
TEST_IN_FOLDER(records_wait_at_most_a_second) {
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_number(track, 1);
    assert_int_equal(info_of(track).committed, 0);
    usleep(1100000);
    push_number(track, 2);
    assert_int_equal(info_of(track).committed, 2);
    push_number(track, 3);
    assert_int_equal(info_of(track).committed, 2);
    toliman_track_destroy(track);
    toliman_track_options each = options;
    each.ledger.sync = TOLIMAN_TRACK_SYNC_FRAME;
    track = make_track(&each);
    push_number(track, 3);
    assert_int_equal(info_of(track).committed, 3);
    toliman_track_destroy(track);
}

enum { RUN = 400 };

/* Pushes all frames, saves occasionally, and prints the number of committed records after each push. */
static void run_child(const toliman_track_options *options, int pipe_end) {
    toliman_track *track = NULL;
    if (toliman_track_create(options, &track) != TOLIMAN_OK)
        _exit(1);
    for (int64_t id = 1; id <= RUN; id++) {
        small_frame frame;
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        toliman_track_info info = {.struct_size = sizeof info};
        size_t done;
        make_frame(&frame, id);
        if (toliman_track_push(track, &frame.frame, 1, &outcome, &done) != TOLIMAN_OK ||
            (id % 37 == 0 && toliman_track_save(track) != TOLIMAN_OK) ||
            toliman_track_get_info(track, &info) != TOLIMAN_OK ||
            write(pipe_end, &info.committed, sizeof info.committed) != (ssize_t)sizeof info.committed)
            _exit(1);
    }
    _exit(0);
}

/* A reader sees a prefix of the writer's records at any moment. */
static void read_during_write(const toliman_track_options *options, int64_t committed) {
    toliman_track_options looking = *options;
    looking.flags = TOLIMAN_TRACK_READ_ONLY;
    for (int repeat = 0; repeat < 5; repeat++) {
        toliman_track *reader = make_track(&looking);
        const int64_t lines = info_of(reader).records;
        assert_true(lines >= committed && lines <= RUN);
        assert_holds(reader, options, 1, lines);
        committed = lines;
        toliman_track_destroy(reader);
    }
}

/* Readers never see damage while a writer is repeatedly stopped and truncates a torn tail. */
TEST_IN_FOLDER(readers_tolerate_recovery) {
    toliman_track_options options = small_options(folder), looking = options;
    options.ledger.sync = TOLIMAN_TRACK_SYNC_FRAME;
    toliman_track_destroy(make_track(&options));
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        for (int64_t id = 1; id < 800; id += 8) {
            toliman_track *track = NULL;
            if (toliman_track_create(&options, &track) != TOLIMAN_OK)
                _exit(1);
            for (int64_t frame = id; frame < id + 8; frame++)
                push_number(track, frame);
            toliman_track_destroy(track);
            const int file = open(ledger, O_WRONLY | O_APPEND);
            static const char torn[5 * LINE + 11] = "torn off";
            if (file < 0 || write(file, torn, sizeof torn) != (ssize_t)sizeof torn)
                _exit(1);
            close(file);
        }
        _exit(0);
    }
    looking.flags = TOLIMAN_TRACK_READ_ONLY;
    int status, reads = 0;
    for (int64_t before = 0; waitpid(child, &status, WNOHANG) == 0; reads++) {
        toliman_track *reader = make_track(&looking);
        const int64_t lines = info_of(reader).records;
        assert_true(lines >= before);
        before = lines;
        toliman_track_destroy(reader);
    }
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0 && reads > 10);
}

/* promise: committed-frames-survive-kills */
TEST_IN_FOLDER(killed_runs_are_resumed) {
    const char *given = getenv("TOLIMAN_KILLS");
    const int kills = given != NULL ? atoi(given) : 10;
    toliman_track_options options = small_options(folder);
    options.ledger.group = 16;
    uint64_t random = 11;
    for (int kill_number = 0; kill_number < kills; kill_number++) {
        int pipe_ends[2];
        int64_t committed = 0, next;
        assert_int_equal(pipe(pipe_ends), 0);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            run_child(&options, pipe_ends[1]);
        close(pipe_ends[1]);
        const uint64_t reports = draw(&random, RUN);
        for (uint64_t i = 0; i < reports; i++)
            if (read(pipe_ends[0], &next, sizeof next) == (ssize_t)sizeof next)
                committed = next;
        if (reports > 0)
            read_during_write(&options, committed);
        usleep((useconds_t)draw(&random, 3000));
        kill(child, SIGKILL);
        while (read(pipe_ends[0], &next, sizeof next) == (ssize_t)sizeof next)
            committed = next;
        close(pipe_ends[0]);
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);

        toliman_track *track = make_track(&options);
        const int64_t there = info_of(track).records;
        assert_true(there >= committed && there <= RUN);
        assert_holds(track, &options, 1, there);
        push_range(track, 1, RUN); /* resumes by replaying all */
        assert_holds(track, &options, 1, RUN);
        toliman_track_destroy(track);
        remove_folder(folder);
        assert_int_equal(mkdir(folder, 0777), 0);
    }
}

/* Names, ids and missing frames of each session and region; a lost name loses no frame. */
/* promise: lost-names-cost-no-frame */
TEST_IN_FOLDER(sessions_are_named) {
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    static const char *const sessions[] = {"night-2", "day.1", "night-2"}, *const rois[] = {"core", "core", "wing"};
    small_frame frame;
    for (int64_t id = 1; id <= 30; id++) {
        make_frame(&frame, id);
        frame.frame.session = sessions[id % 3];
        frame.frame.roi = rois[id % 3];
        push_one(track, &frame.frame);
        push_one(track, &frame.frame); /* again: no other key */
    }
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    char names[300];
    snprintf(names, sizeof names, "%s/streams.txt", folder);
    const off_t size = size_of(names);
    for (int damage = 0; damage < 3; damage++) {
        if (damage == 1) /* a letter of a name, and the last line truncated */
            flip_byte(names, 19), assert_int_equal(truncate(names, size - 4), 0);
        if (damage == 2)
            assert_int_equal(unlink(names), 0);
        track = make_track(&options);
        toliman_track_stream streams[3] = {{.struct_size = sizeof *streams}};
        size_t count = 0;
        assert_asks(toliman_track_get_streams(track, NULL, 0, &count));
        assert_int_equal(count, 3);
        assert_refused(toliman_track_get_streams(track, streams, 2, &count), TOLIMAN_E_CAPACITY, "capacity");
        assert_ok(toliman_track_get_streams(track, streams, 3, &count));
        int named = 0;
        for (int i = 0; i < 3; i++) {
            char both[200];
            const int length = snprintf(both, sizeof both, "%s%c%s", streams[i].session, 0, streams[i].roi);
            if (streams[i].session[0] != 0) {
                assert_true(streams[i].stream == fnv1a(both, (size_t)length));
                named++;
            }
            assert_int_equal(streams[i].frames, 10);
            assert_int_equal(streams[i].last_id - streams[i].first_id, 27);
            assert_int_equal(streams[i].missing, 18);
        }
        assert_int_equal(named, damage == 0 ? 3 : damage == 1 ? 1 : 0);
        if (damage == 0) {
            assert_string_equal(streams[0].session, "day.1");
            assert_string_equal(streams[1].roi, "core");
            assert_string_equal(streams[2].roi, "wing");
        }
        for (int64_t id = 31; id <= 33 && damage > 0; id++) { /* and with the next frame it is known again */
            make_frame(&frame, id + damage * 3);
            frame.frame.session = sessions[id % 3];
            frame.frame.roi = rois[id % 3];
            push_one(track, &frame.frame);
        }
        if (damage > 0) {
            assert_ok(toliman_track_get_streams(track, streams, 3, &count));
            assert_true(streams[0].session[0] && streams[1].session[0] && streams[2].session[0]);
        }
        toliman_track_destroy(track);
    }
    toliman_track_options elsewhere = small_options(NULL);
    char copy[300];
    snprintf(copy, sizeof copy, "%s/copy", folder);
    elsewhere.folder = copy;
    track = make_track(&elsewhere);
    assert_ok(toliman_track_merge(track, folder, 0, NULL));
    toliman_track_stream streams[3] = {{.struct_size = sizeof *streams}};
    size_t count = 0;
    assert_ok(toliman_track_get_streams(track, streams, 3, &count));
    assert_string_equal(streams[0].session, "day.1");
    toliman_track_destroy(track);
    remove_folder(copy);
}

/* A checkpoint is valid only for the ledger, grid and clock that it was made of. */
/* promise: lost-checkpoints-cost-time-only */
TEST_IN_FOLDER(foreign_checkpoint_is_ignored) {
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options), *none = NULL;
    push_range(track, 1, 20);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    char first[300];
    snprintf(first, sizeof first, "%s/first", folder);
    copy_file(checkpoint, first);

    const int64_t clock[] = {0, 5000};
    toliman_track_options other = options;
    other.clock.pairs = clock;
    other.clock.count = 1;
    other.flags = TOLIMAN_TRACK_REBUILD;
    toliman_track_destroy(make_track(&other));
    copy_file(first, checkpoint);
    other.flags = 0;
    track = make_track(&other);
    toliman_track_options fresh = other;
    fresh.folder = NULL;
    toliman_track *expected = make_track(&fresh);
    push_range(expected, 1, 20);
    assert_same_periods(period_of(track), period_of(expected));
    toliman_track_record line = {.struct_size = sizeof line};
    size_t done;
    assert_ok(toliman_track_get_records(track, 3, 1, &line, &done));
    assert_int_equal(line.tai_ns - line.camera_ns, 5000);
    toliman_track_destroy(expected), toliman_track_destroy(track);

    /* Another ledger with the same salt: the first 20 records differ. */
    assert_int_equal(truncate(ledger, HEADER + 5 * LINE), 0);
    assert_int_equal(unlink(checkpoint), 0);
    track = make_track(&other);
    push_range(track, 41, 70);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    copy_file(first, checkpoint);
    assert_fails(toliman_track_create(&other, &none), TOLIMAN_E_FORMAT,
                 "first 20 records are not those that the checkpoint counts");
    unlink(first);
}

/* The setup of a folder with another sigma, whose sums could not hold these values. */
TEST_IN_FOLDER(foreign_setup_is_ignored) {
    char copy[300], other_setup[320];
    toliman_track_options options = small_options(folder), other = options;
    toliman_track *none = NULL;
    snprintf(copy, sizeof copy, "%s/copy", folder);
    other.folder = copy;
    other.estimator.sigma *= 2;
    toliman_track_destroy(make_track(&options)), toliman_track_destroy(make_track(&other));
    snprintf(other_setup, sizeof other_setup, "%s/setup.tlms", copy);
    copy_file(setup, other_setup);
    other.grid.nf = 0;
    assert_invalid(toliman_track_create(&other, &none), "options->grid.nf");
    remove_folder(copy);
}

RUN_TESTS(NULL, NULL)
