/* Tests trackers whose folder is damaged: files with flipped bytes, truncated or missing; impossible records; a full
 * disk. */
#include <signal.h>
#include <sys/resource.h>

#include "samples.h"
#include "track_folder.h"

/* With each byte of the checkpoint flipped, the file truncated or missing, the sums are recomputed from the ledger. */
/* promise: lost-checkpoints-cost-time-only */
TEST_IN_FOLDER(lost_checkpoint_costs_only_time) {
    toliman_track_options options = filled_folder();
    const off_t size = size_of(checkpoint);
    for (off_t at = 0; at < size; at += at < 64 ? 1 : 401) {
        flip_byte(checkpoint, at);
        toliman_track *track = make_track(&options);
        assert_filled(track, &options);
        toliman_track_destroy(track);
    }
    for (off_t cut = 0; cut < size; cut += 1 + cut) {
        assert_int_equal(truncate(checkpoint, cut), 0);
        toliman_track *track = make_track(&options);
        assert_filled(track, &options);
        toliman_track_destroy(track);
    }
    assert_int_equal(unlink(checkpoint), 0);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    options.grid.nf = 0;
    toliman_track *track = make_track(&options);
    options.grid.nf = FREQUENCIES;
    assert_filled(track, &options);
    assert_int_equal(info_of(track).committed, 42); /* the records after the checkpoint carry the earlier counts */
    toliman_track_destroy(track);
    assert_int_equal(access(checkpoint, F_OK), -1);
}

/* With each byte of the setup (grid and clock) flipped, the file truncated or missing: neither is guessed, both can be
 * given again. */
TEST_IN_FOLDER(lost_setup_must_be_given_again) {
    const toliman_track_options options = filled_folder();
    const int64_t camera[2] = {0, 0};
    toliman_track_options given = options, known;
    given.clock.pairs = camera;
    given.clock.count = 1;
    toliman_track *none = NULL;
    const off_t size = size_of(setup);
    for (off_t at = 0; at <= size; at++) {
        toliman_track_options without = options;
        at < size ? flip_byte(setup, at) : (void)unlink(setup);
        if (at < size && at % 8 != 0) { /* no byte may change; the rest for some of them */
            assert_invalid(toliman_track_create(&without, &none), "options->clock.pairs");
            flip_byte(setup, at);
            continue;
        }
        for (uint32_t flags = 0; flags <= TOLIMAN_TRACK_REBUILD; flags++) {
            without.flags = flags;
            assert_invalid(toliman_track_create(&without, &none), "options->clock.pairs");
        }
        without.grid.nf = 0;
        assert_invalid(toliman_track_create(&without, &none), "options->grid.nf");
        known.struct_size = sizeof known;
        assert_ok(toliman_track_load_options(folder, &known));
        assert_int_equal(known.grid.nf, 0);
        given.frames.stamp = 0;
        assert_invalid(toliman_track_create(&given, &none), "options->frames.stamp");
        given.frames.stamp = TOLIMAN_FRAME_STAMP_MIDDLE;
        toliman_track *track = make_track(&given);
        assert_filled(track, &options); /* nor is the checkpoint lost */
        toliman_track_destroy(track);
        track = make_track(&options); /* rewritten */
        toliman_track_destroy(track);
    }
}

/* Damage to a synced record is never mistaken for a crash; a torn tail is truncated. */
TEST_IN_FOLDER(damaged_ledger_is_distinguished_from_a_torn_one) {
    toliman_track_options options = small_options(folder);
    options.ledger.group = 8;
    toliman_track *track = make_track(&options), *none = NULL;
    push_range(track, 1, 24);
    toliman_track_destroy(track);
    assert_int_equal(size_of(ledger), HEADER + 24 * LINE);
    assert_int_equal(unlink(checkpoint), 0);
    for (off_t at = 0; at < HEADER + 16 * LINE; at += at < HEADER ? 5 : 29) {
        flip_byte(ledger, at);
        const toliman_status expected = at < HEADER ? TOLIMAN_E_FORMAT : TOLIMAN_E_LOST;
        assert_refused(toliman_track_create(&options, &none), expected, ledger);
        options.flags = TOLIMAN_TRACK_READ_ONLY;
        assert_refused(toliman_track_create(&options, &none), expected, ledger);
        options.flags = 0;
        flip_byte(ledger, at);
    }
    flip_byte(ledger, HEADER + 3 * LINE);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_LOST, "record 3 is damaged");
    flip_byte(ledger, HEADER + 3 * LINE);
    /* The last group may be torn: record 20 damaged, and a partial record at the end. */
    flip_byte(ledger, HEADER + 20 * LINE + 7);
    write_at(ledger, HEADER + 24 * LINE, "half a line", 11);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    track = make_track(&options);
    assert_holds(track, &options, 1, 20);
    toliman_track_destroy(track);
    assert_int_equal(size_of(ledger), HEADER + 24 * LINE + 11); /* a reader changes nothing */
    options.flags = 0;
    track = make_track(&options);
    assert_holds(track, &options, 1, 20);
    assert_int_equal(size_of(ledger), HEADER + 20 * LINE);
    push_range(track, 21, 30);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);

    /* Damage in the last group, which the checkpoint covers: refused, and nothing is truncated. */
    flip_byte(ledger, HEADER + 29 * LINE + 7);
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_LOST, ledger);
    assert_int_equal(size_of(ledger), HEADER + 30 * LINE);
    flip_byte(ledger, HEADER + 29 * LINE + 7);

    /* Records that the checkpoint counts but the ledger lacks. */
    assert_int_equal(truncate(ledger, HEADER + 29 * LINE), 0);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_LOST,
                 "29 valid records, but the checkpoint counts 30");
    options.flags = TOLIMAN_TRACK_REBUILD; /* rebuilding must not hide the loss */
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_LOST, ledger);
    options.flags = 0;
    /* A different ledger of the same length is detected, too. */
    flip_byte(checkpoint, 33);
    toliman_track *track_after = make_track(&options);
    toliman_track_destroy(track_after);
    assert_int_equal(unlink(ledger), 0);
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, ledger);
    assert_refused(toliman_track_load_options(folder, &options), TOLIMAN_E_FORMAT, ledger);
    assert_int_equal(symlink("/etc/passwd", ledger), 0);
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, ledger);
    assert_null(none);
}

/* Frames whose times the grid or clock cannot represent stay in the ledger, and enter the sums with another grid or
 * clock. */
TEST_IN_FOLDER(times_out_of_range_lose_no_frame) {
    toliman_track_options options = filled_folder(), other = options;
    const int64_t late[2] = {0, INT64_MAX - 30 * DAY_NS}, camera[2] = {0, 0};
    other.flags = TOLIMAN_TRACK_REBUILD;
    other.clock.count = 1;
    for (int trial = 0; trial < 2; trial++) {
        other.clock.pairs = trial ? camera : late; /* frames after day 30 exceed 64 bits; or all exceed 2^50 cycles */
        other.grid.df = trial ? 1e16 : options.grid.df;
        toliman_track *track = make_track(&other), *merged;
        const toliman_track_info info = info_of(track);
        assert_int_equal(info.quarantined, 3);
        assert_int_equal(info.accepted + info.outlier, 57);
        assert_true(trial ? info.accepted == 0 : info.accepted > 20 && info.accepted < 30);
        assert_int_equal(count_of(period_of(track)), info.accepted);
        small_frame frame; /* a frame outside the sums is not retracted from them */
        make_frame(&frame, 45);
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
        toliman_track_options elsewhere = other;
        elsewhere.folder = NULL;
        elsewhere.flags = 0;
        merged = make_track(&elsewhere);
        assert_ok(toliman_track_merge(merged, folder, 0, NULL));
        assert_same_periods(period_of(merged), period_of(track));
        make_frame(&frame, 46);
        frame.pixels[1]++;
        assert_int_equal(push_one(merged, &frame.frame).reason, TOLIMAN_TRACK_REASON_CLOCK);
        assert_int_equal(info_of(merged).outlier, info.outlier);
        toliman_track_destroy(merged), toliman_track_destroy(track);
    }
    other.clock.pairs = camera;
    other.grid.df = options.grid.df;
    toliman_track *track = make_track(&other);
    assert_filled(track, &options);
    toliman_track_destroy(track);
}

/* Undamaged records of a damaged ledger are merged to a new folder; the lost ones are counted. */
/* promise: salvage-counts-what-is-lost */
TEST_IN_FOLDER(damaged_ledger_is_salvaged) {
    toliman_track_options options = small_options(folder), elsewhere = small_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame frame;
    push_range(track, 1, 40);
    for (int64_t id = 4; id <= 36; id += 32) {
        make_frame(&frame, id);
        frame.pixels[1]++;
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    }
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    flip_byte(ledger, HEADER + 3 * LINE + 20);                      /* frame 4; its quarantine record is intact */
    flip_byte(ledger, HEADER + 18 * LINE - 2);                      /* the checksum that the next record continues */
    assert_int_equal(truncate(ledger, HEADER + 41 * LINE + 30), 0); /* the quarantine record of frame 36 */
    track = make_track(&elsewhere);
    int64_t lost = -1;
    assert_fails(toliman_track_merge(track, folder, 0, &lost), TOLIMAN_E_LOST, "3 valid records");
    assert_invalid(toliman_track_merge(track, folder, 2, &lost), "flags");
    for (int time = 0; time < 2; time++) {
        assert_ok(toliman_track_merge(track, folder, TOLIMAN_TRACK_SALVAGE, &lost));
        assert_int_equal(info_of(track).accepted + info_of(track).outlier, 37);
        assert_int_equal(info_of(track).quarantined, 1); /* frame 4, by its quarantine record */
        assert_int_equal(lost, 4);                       /* records 3, 17, 18 and 41 */
    }
    toliman_period *clean = clean_period(&options);
    for (int64_t id = 1; id <= 40; id++)
        if (id != 4 && id != 18 && id != 19)
            push_clean(clean, id);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean), toliman_track_destroy(track);
}

/* Impossible records with correct checksums are refused, and never mistaken for torn ones. */
/* promise: impossible-records-are-refused */
TEST_IN_FOLDER(impossible_records_are_refused) {
    toliman_track_options options = small_options(folder), elsewhere = small_options(NULL);
    toliman_track *track = make_track(&options), *none = NULL;
    push_number(track, 1);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    unsigned char good[LINE], line[LINE];
    const uint32_t before = (uint32_t)number_at(ledger, HEADER - 4, 4);
    read_at(ledger, HEADER, good, LINE);
    const double wrong[] = {NAN, 2 * VALUE_LIMIT, SIGMA / 2, 33 * SIGMA};
    for (int trial = 0; trial < 8; trial++) {
        memcpy(line, good, LINE);
        if (trial < 3)
            line[52] = (unsigned char)(trial == 0 ? 3 : trial == 1 ? 0 : 7); /* kind */
        else if (trial == 3)
            line[53] = 9; /* one more than the last reason */
        else
            memcpy(line + (trial < 6 ? 36 : 44), &wrong[trial - 4], 8);
        const uint32_t crc = crc32(before, line, LINE - 4);
        memcpy(line + LINE - 4, &crc, 4);
        write_at(ledger, HEADER, line, LINE);
        assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, ledger);
        track = make_track(&elsewhere);
        assert_refused(toliman_track_merge(track, folder, 0, NULL), TOLIMAN_E_FORMAT, ledger);
        assert_int_equal(info_of(track).received, 0);
        toliman_track_destroy(track);
        assert_int_equal(size_of(ledger), HEADER + LINE);
    }
}

/* A full disk: the error is reported, no more frames are accepted, and acknowledged frames are there once space is
 * available. */
/* promise: failed-writes-stop-the-tracker */
TEST_IN_FOLDER(full_disk_is_reported) {
    toliman_track_options options = small_options(folder);
    options.ledger.group = 4;
    toliman_track *track = make_track(&options);
    const struct rlimit limit = {HEADER + 10 * LINE, RLIM_INFINITY}, none = {RLIM_INFINITY, RLIM_INFINITY};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    push_range(track, 1, 11);
    small_frame frame;
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done = 9;
    make_frame(&frame, 12);
    assert_int_equal(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_WRITE);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &none), 0);
    assert_int_equal(done, 0);
    assert_refused(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_WRITE, ledger);
    assert_refused(toliman_track_commit(track), TOLIMAN_E_WRITE, ledger);
    assert_refused(toliman_track_save(track), TOLIMAN_E_WRITE, ledger);
    assert_int_equal(info_of(track).committed, 8);
    assert_int_equal(info_of(track).received, 11);
    toliman_track_destroy(track);
    track = make_track(&options);
    const int64_t there = info_of(track).records;
    assert_true(there >= 8 && there <= 11);
    assert_holds(track, &options, 1, there);
    push_range(track, 1, 20);
    assert_holds(track, &options, 1, 20);
    toliman_track_destroy(track);
}

/* After one salvage, a folder can be merged as before, and its later records are not skipped. */
/* promise: salvage-counts-what-is-lost */
TEST_IN_FOLDER(salvage_hides_nothing) {
    char region_path[300];
    snprintf(region_path, sizeof region_path, "%s/region", folder);
    toliman_track_options options = small_options(folder), of_region = options, elsewhere = small_options(NULL);
    of_region.folder = region_path;
    toliman_track *shard = make_track(&options), *region = make_track(&of_region), *mission = make_track(&elsewhere);
    push_range(shard, 1, 40);
    assert_ok(toliman_track_save(shard));
    assert_ok(toliman_track_merge(region, folder, 0, NULL));
    assert_ok(toliman_track_save(region));
    toliman_track_destroy(region);
    char region_ledger[320];
    snprintf(region_ledger, sizeof region_ledger, "%s/ledger.tlml", region_path);
    flip_byte(region_ledger, HEADER + 5 * LINE);
    int64_t lost = 0;
    assert_ok(toliman_track_merge(mission, region_path, TOLIMAN_TRACK_SALVAGE, &lost));
    assert_int_equal(lost, 1);
    assert_ok(toliman_track_merge(mission, folder, 0, NULL)); /* holds the record that the region lost */
    assert_holds(mission, &options, 1, 40);
    /* An undamaged folder that was salvaged, and grows. */
    assert_ok(toliman_track_merge(mission, folder, TOLIMAN_TRACK_SALVAGE, &lost));
    assert_int_equal(lost, 0);
    push_range(shard, 41, 60);
    assert_ok(toliman_track_save(shard));
    toliman_track_destroy(shard);
    assert_ok(toliman_track_merge(mission, folder, 0, NULL));
    assert_holds(mission, &options, 1, 60);
    /* A folder shortened by a power cut, which continued with other frames. */
    assert_int_equal(truncate(ledger, HEADER + 20 * LINE), 0);
    assert_int_equal(unlink(checkpoint), 0);
    shard = make_track(&options);
    push_range(shard, 61, 100);
    assert_ok(toliman_track_save(shard));
    assert_ok(toliman_track_merge(mission, folder, 0, NULL));
    assert_holds(mission, &options, 1, 100);
    toliman_track_destroy(shard), toliman_track_destroy(mission);
    remove_folder(region_path);
}

/* The frame of a lost record stays quarantined, whether another folder with that frame is merged before or after. */
/* promise: quarantines-retract-exactly */
TEST_IN_FOLDER(salvaged_quarantines_hold_in_any_order) {
    char other_path[300];
    snprintf(other_path, sizeof other_path, "%s/other", folder);
    toliman_track_options options = small_options(folder), of_other = options, elsewhere = small_options(NULL);
    of_other.folder = other_path;
    toliman_track *track = make_track(&options);
    small_frame frame;
    push_range(track, 1, 9);
    make_frame(&frame, 4);
    frame.pixels[1]++;
    push_one(track, &frame.frame);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    flip_byte(ledger, HEADER + 3 * LINE);
    for (int same = 0; same < 2; same++) { /* the other folder holds the lost frame, or the contradicting copy */
        track = make_track(&of_other);
        make_frame(&frame, 4);
        frame.pixels[1] = (uint16_t)(frame.pixels[1] + same);
        push_one(track, &frame.frame);
        assert_ok(toliman_track_commit(track));
        toliman_track_destroy(track);
        for (int order = 0; order < 2; order++) {
            track = make_track(&elsewhere);
            for (int i = 0; i < 2; i++)
                assert_ok(toliman_track_merge(track, i == order ? folder : other_path, TOLIMAN_TRACK_SALVAGE, NULL));
            assert_int_equal(info_of(track).quarantined, 1);
            assert_int_equal(info_of(track).accepted + info_of(track).outlier, 8);
            toliman_track_destroy(track);
        }
        remove_folder(other_path);
    }
}

/* Impossible counts of a folder are refused before any of them is merged. */
TEST_IN_FOLDER(impossible_marks_do_not_spread) {
    char crafted_path[300], crafted[320];
    snprintf(crafted_path, sizeof crafted_path, "%s/crafted", folder);
    snprintf(crafted, sizeof crafted, "%s/ledger.tlml", crafted_path);
    toliman_track_options options = small_options(folder), of_crafted = options;
    of_crafted.folder = crafted_path;
    toliman_track_destroy(make_track(&of_crafted));
    uint32_t chain = (uint32_t)number_at(crafted, HEADER - 4, 4);
    for (int i = 0; i < 3; i++) {
        unsigned char line[LINE] = {0};
        const int64_t repeats = (int64_t)1 << 60;
        const double sigma = SIGMA;
        line[0] = (unsigned char)(i + 1);
        memcpy(line + 20, &repeats, 8);
        memcpy(line + 44, &sigma, 8);
        line[52] = 5;
        chain = crc32(chain, line, LINE - 4);
        memcpy(line + LINE - 4, &chain, 4);
        write_at(crafted, HEADER + i * LINE, line, LINE);
    }
    toliman_track *track = make_track(&options), *none = NULL;
    push_range(track, 1, 5);
    assert_refused(toliman_track_merge(track, crafted_path, 0, NULL), TOLIMAN_E_FORMAT, crafted);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_int_equal(info_of(track).received, 5);
    toliman_track_destroy(track);
    assert_refused(toliman_track_create(&of_crafted, &none), TOLIMAN_E_FORMAT, crafted);
    remove_folder(crafted_path);
}

RUN_TESTS(NULL, NULL)
