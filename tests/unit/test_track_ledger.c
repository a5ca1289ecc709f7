/* Tests the tracker's ledger: one writer even if other files are removed, a ledger that is removed or changed under its
 * writer, missing files, counts that survive a crash, and warnings about damage. */
#include <sys/file.h>
#include <sys/wait.h>

#include "track_folder.h"

static char names[300], warnings[4096];

static int prepare(void **state) {
    set_up(state);
    snprintf(names, sizeof names, "%s/streams.txt", folder);
    return 0;
}

static void note(int32_t level, const char *text, void *user_data) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    assert_ptr_equal(user_data, warnings);
    strncat(warnings, text, sizeof warnings - strlen(warnings) - 2);
    strcat(warnings, "\n");
}

/* Opens the folder and returns the number of warnings. */
static int count_warnings(toliman_track_options options, uint32_t flags) {
    int count = 0;
    warnings[0] = '\0';
    options.flags = flags;
    options.log = note;
    options.log_data = warnings;
    toliman_track_destroy(make_track(&options));
    for (const char *at = warnings; (at = strchr(at, '\n')) != NULL; at++)
        count++;
    return count;
}

/* A reader is warned each time; a writer is warned once and repairs the damage. */
static void assert_warned(const toliman_track_options *options, const char *text, int repaired) {
    assert_int_equal(count_warnings(*options, TOLIMAN_TRACK_READ_ONLY), 1);
    assert_non_null(strstr(warnings, text));
    assert_int_equal(count_warnings(*options, 0), 1);
    assert_non_null(strstr(warnings, text));
    assert_int_equal(count_warnings(*options, 0), !repaired);
}

/* promise: damage-is-told-once */
TEST_WITH(damage_is_reported_once, prepare, tear_down) {
    const toliman_track_options options = filled_folder();
    char copy[300];
    snprintf(copy, sizeof copy, "%s/copy", folder);
    assert_int_equal(count_warnings(options, TOLIMAN_TRACK_READ_ONLY), 0);
    assert_int_equal(count_warnings(options, 0), 0);
    flip_byte(checkpoint, size_of(checkpoint) / 2);
    assert_warned(&options, "checkpoint.tlmc: is damaged: the sums are computed again", 1);
    assert_int_equal(truncate(checkpoint, 100), 0);
    assert_warned(&options, "checkpoint.tlmc: is damaged", 1);
    assert_int_equal(unlink(checkpoint), 0);
    assert_warned(&options, "checkpoint.tlmc: is missing", 1);
    toliman_track_options other = options;
    other.folder = copy;
    toliman_track_destroy(make_track(&other));
    char theirs[330];
    snprintf(theirs, sizeof theirs, "%s/checkpoint.tlmc", copy);
    assert_int_equal(rename(theirs, checkpoint), 0);
    assert_warned(&options, "checkpoint.tlmc: belongs to another ledger", 1);
    write_at(ledger, size_of(ledger), "half a line", 11);
    assert_warned(&options, "ledger.tlml: 11 bytes after 65 valid records are incomplete", 1);
    flip_byte(names, 20);
    assert_warned(&options, "streams.txt: is damaged or incomplete: the names of 1 of 1 sessions", 0);
    toliman_track *track = make_track(&options);
    push_number(track, 61); /* a frame writes its names again */
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    assert_int_equal(count_warnings(options, 0), 0);
    track = make_track(&options);
    assert_int_equal(info_of(track).repeated, FILLED_REPEATS);
    toliman_track_destroy(track);
    remove_folder(copy);
}

/* promise: folders-have-one-writer */
TEST_WITH(one_writer_even_if_files_are_removed, prepare, tear_down) {
    char path[330];
    static const char *const other_files[] = {"lock", "checkpoint.tlmc", "setup.tlms", "streams.txt",
                                              "ledger.tlml.tmp"};
    const toliman_track_options options = small_options(folder);
    toliman_track *writer = make_track(&options), *none = NULL;
    push_range(writer, 1, 3);
    for (size_t i = 0; i < sizeof other_files / sizeof *other_files; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, other_files[i]);
        unlink(path);
        assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_STATE, folder);
    }
    push_range(writer, 4, 70);
    assert_ok(toliman_track_save(writer));
    toliman_track_destroy(writer);
    snprintf(path, sizeof path, "%s/lock", folder);
    assert_int_equal(access(path, F_OK), -1);
}

enum { REMOVED, RENAMED, REPLACED, CUT, GROWN, WAYS };

static void damage_ledger(int way) {
    char aside[330], command[1400];
    snprintf(aside, sizeof aside, "%s/aside", folder);
    snprintf(command, sizeof command, "cp %s %s && mv %s %s", ledger, aside, aside, ledger);
    if (way == REMOVED)
        assert_int_equal(unlink(ledger), 0);
    else if (way == RENAMED)
        assert_int_equal(rename(ledger, aside), 0);
    else if (way == REPLACED)
        assert_int_equal(system(command), 0);
    else if (way == CUT)
        assert_int_equal(truncate(ledger, HEADER + LINE), 0);
    else
        write_at(ledger, size_of(ledger), command, LINE);
}

/* The change is detected before anything more is acknowledged; a removed file is never saved to. */
/* promise: changed-ledgers-stop-writers */
TEST_WITH(a_ledger_that_changes_stops_its_writer, prepare, tear_down) {
    for (int way = 0; way < WAYS; way++)
        for (int saving = 0; saving < 2; saving++) {
            toliman_track_options options = small_options(folder);
            options.ledger.group = 4;
            toliman_track *track = make_track(&options);
            push_range(track, 1, 8);
            damage_ledger(way);
            small_frame frame;
            toliman_track_outcome outcome = {.struct_size = sizeof outcome};
            toliman_status status = TOLIMAN_OK;
            size_t done = 1;
            for (int64_t id = 9; id <= 12 && status == TOLIMAN_OK && !saving; id++) {
                make_frame(&frame, id);
                status = toliman_track_push(track, &frame.frame, 1, &outcome, &done);
            }
            if (saving)
                status = toliman_track_save(track);
            assert_int_equal(status, TOLIMAN_E_LOST);
            assert_string_equal(toliman_last_error_field(), ledger);
            assert_int_equal(info_of(track).committed, 8);
            assert_refused(toliman_track_commit(track), TOLIMAN_E_LOST, ledger);
            assert_refused(toliman_track_save(track), TOLIMAN_E_LOST, ledger);
            toliman_track_destroy(track);
            remove_folder(folder);
            assert_int_equal(mkdir(folder, 0777), 0);
        }
}

enum { ROUNDS = 25, WRITERS = 4, FRAMES = 6 };

/* Returns the number of acknowledged frames, 0 if another process is writing. */
static int write_some(int writer) {
    const toliman_track_options options = small_options(folder);
    toliman_track *track = NULL;
    const toliman_status status = toliman_track_create(&options, &track);
    if (status == TOLIMAN_E_STATE)
        return 0;
    if (status != TOLIMAN_OK) {
        fprintf(stderr, "%s\n", toliman_last_error());
        return 100;
    }
    push_range(track, 1 + writer * FRAMES, (writer + 1) * FRAMES);
    if (toliman_track_commit(track) != TOLIMAN_OK)
        return 100;
    toliman_track_destroy(track);
    return FRAMES;
}

/* Writers that race to create a folder: each writes alone or is refused, and no acknowledged frame is lost. */
/* promise: folders-have-one-writer */
TEST_WITH(race_to_create_a_folder, prepare, tear_down) {
    const toliman_track_options options = small_options(folder);
    for (int round = 0; round < ROUNDS; round++) {
        pid_t children[WRITERS];
        for (int writer = 0; writer < WRITERS; writer++)
            if ((children[writer] = fork()) == 0)
                _exit(write_some(writer));
        int acknowledged = 0, status;
        for (int writer = 0; writer < WRITERS; writer++) {
            assert_int_equal(waitpid(children[writer], &status, 0), children[writer]);
            assert_true(WIFEXITED(status) && WEXITSTATUS(status) <= FRAMES);
            acknowledged += WEXITSTATUS(status);
        }
        assert_true(acknowledged > 0);
        toliman_track *track = make_track(&options);
        assert_int_equal(info_of(track).records, acknowledged);
        toliman_track_destroy(track);
        remove_folder(folder);
        assert_int_equal(mkdir(folder, 0777), 0);
    }
}

/* A writer of an earlier version locks the file `lock`. */
TEST_WITH(writer_of_an_earlier_version_is_excluded, prepare, tear_down) {
    char path[330];
    snprintf(path, sizeof path, "%s/lock", folder);
    const int held = open(path, O_RDWR | O_CREAT, 0666);
    assert_int_equal(flock(held, LOCK_EX), 0);
    const toliman_track_options options = small_options(folder);
    toliman_track *none = NULL;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_STATE, folder);
    close(held);
    toliman_track_destroy(make_track(&options));
}

/* If files other than the ledger exist, the folder is not new, and no new ledger is created. */
TEST_WITH(lost_ledger_is_not_a_new_folder, prepare, tear_down) {
    const toliman_track_options options = filled_folder();
    toliman_track_options reading = options;
    reading.flags = TOLIMAN_TRACK_READ_ONLY;
    const char *const left[] = {checkpoint, setup, names};
    toliman_track *none = NULL;
    assert_int_equal(unlink(ledger), 0);
    for (int i = 0; i < 3; i++) {
        assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, ledger);
        assert_refused(toliman_track_create(&reading, &none), TOLIMAN_E_FORMAT, ledger);
        assert_int_equal(access(ledger, F_OK), -1);
        assert_int_equal(unlink(left[i]), 0);
    }
    toliman_track_destroy(make_track(&options));
}

/* As after a crash that left only the first file. */
TEST_WITH(partly_created_folder_continues, prepare, tear_down) {
    toliman_track_options options = small_options(folder);
    for (int left = 0; left < 2; left++) {
        toliman_track_destroy(make_track(&options));
        assert_int_equal(unlink(checkpoint) + unlink(setup) + unlink(names), 0);
        if (left) { /* or only a temporary file */
            char temporary[330];
            snprintf(temporary, sizeof temporary, "%s.tmp", ledger);
            assert_int_equal(rename(ledger, temporary), 0);
        }
        toliman_track_options none = TOLIMAN_TRACK_OPTIONS_INIT;
        assert_refused(toliman_track_load_options(folder, &none), TOLIMAN_E_NOT_FOUND, folder);
        assert_int_equal(count_warnings(options, 0), 0);
        toliman_track *track = make_track(&options);
        push_range(track, 1, 5);
        assert_ok(toliman_track_commit(track));
        assert_holds(track, &options, 1, 5);
        toliman_track_destroy(track);
        remove_folder(folder);
        assert_int_equal(mkdir(folder, 0777), 0);
    }
}

/* Arrivals are counted once, without a save and without the checkpoint. */
/* promise: counts-survive-crashes */
TEST_WITH(repeats_are_kept_by_commit, prepare, tear_down) {
    const toliman_track_options options = small_options(folder);
    for (int pass = 1; pass <= 4; pass++) {
        toliman_track *track = make_track(&options);
        assert_int_equal(info_of(track).repeated, 20 * (pass - 1));
        for (int again = 0; again < (pass == 1 ? 3 : 2); again++)
            push_range(track, 1, 10);
        assert_int_equal(info_of(track).repeated, 20 * pass);
        assert_ok(pass == 2 ? toliman_track_save(track) : toliman_track_commit(track));
        toliman_track_destroy(track);
        if (pass == 3)
            assert_int_equal(unlink(checkpoint), 0);
    }
    toliman_track *track = make_track(&options);
    const toliman_track_info info = info_of(track);
    assert_int_equal(info.received, 90);
    assert_int_equal(info.records, 10 + 4);
    push_number(track, 1); /* not committed: lost, since it was never acknowledged */
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_int_equal(info_of(track).received, 90);
    toliman_track_destroy(track);
}

/* A checkpoint of an earlier version, which held these counts alone: they count once, also after the ledger has
 * them. */
/* promise: counts-survive-crashes */
TEST_WITH(repeats_of_an_older_checkpoint_count_once, prepare, tear_down) {
    enum { REPEATS = 24 };
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_range(track, 1, 10);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    static unsigned char bytes[1 << 16];
    const off_t size = size_of(checkpoint);
    const int64_t seven = 7;
    write_at(checkpoint, REPEATS, &seven, 8);
    read_at(checkpoint, 0, bytes, (size_t)size);
    const uint32_t crc = crc32(0, bytes, (size_t)size - 4);
    write_at(checkpoint, size - 4, &crc, 4);
    for (int time = 0; time < 3; time++) {
        track = make_track(&options);
        assert_int_equal(info_of(track).repeated, 7);
        assert_ok(toliman_track_commit(track));
        toliman_track_destroy(track);
    }
    toliman_track_options elsewhere = small_options(NULL);
    track = make_track(&elsewhere);
    assert_ok(toliman_track_merge(track, folder, 0, NULL));
    assert_int_equal(info_of(track).repeated, 7);
    toliman_track_destroy(track);
}

/* The sums of more records than are pushed together: by one thread and by three, and merged as they were saved, or
 * without a checkpoint, or with two frames that are known already. */
/* promises: arrival-order-changes-no-bit, folders-merge-in-any-order */
TEST_IN_FOLDER(sums_of_many_records_have_the_same_bits) {
    enum { MANY = 20000, KNOWN = 2 };
    toliman_track_options options = small_options(folder);
    options.ledger.capacity = 2 * MANY;
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    toliman_track *track = make_track(&options);
    push_range(track, 1, MANY);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    toliman_period *clean = clean_period(&options);
    for (int64_t id = 1; id <= MANY; id++)
        push_clean(clean, id);
    toliman_track_options merged = options;
    merged.folder = NULL;
    for (int known = 0; known <= KNOWN; known += KNOWN)
        for (int saved = 1; saved >= 0; saved--) {
            toliman_track *other = make_track(&merged);
            push_range(other, 1, known);
            if (!saved)
                assert_int_equal(unlink(checkpoint), 0);
            assert_ok(toliman_track_merge(other, folder, 0, NULL));
            assert_int_equal(info_of(other).repeated, known);
            assert_same_periods(period_of(other), clean);
            toliman_track_destroy(other);
            options.threads = saved ? 1 : 3;
            track = make_track(&options); /* saves the sums again */
            assert_same_periods(period_of(track), clean);
            toliman_track_destroy(track);
        }
    toliman_period_destroy(clean);
}

RUN_TESTS(NULL, NULL)
