/* Tests that reduced frames are reduced again from the ledger alone: rebuilding, merging, damage, and locking. */
#include <sys/wait.h>

#include "reduced_folder.h"

static toliman_track_options options_without_setup(void) {
    static const int64_t clock[] = {0, 0};
    toliman_track_options options = measured_options(folder);
    options.clock.pairs = clock;
    options.clock.count = 1;
    options.frames.stamp = TOLIMAN_FRAME_STAMP_MIDDLE;
    return options;
}

/* The setup is lost, or is that of another ledger: either would give values of another reference. */
TEST_IN_FOLDER(lost_setup_needs_the_sky) {
    for (int is_predicted = 0; is_predicted < 2; is_predicted++) {
        fill_folder(is_predicted ? predicted : orbit, is_predicted ? COVERED + 2 : 1, LAST);
        assert_int_equal(unlink(setup), 0);
        toliman_track_options options = options_without_setup();
        toliman_track *track = NULL;
        assert_invalid(toliman_track_create(&options, &track), "options->reduction.sky");
        options.reduction.sky = is_predicted ? predicted : orbit;
        options.reduction.plate_scale_arcsec = SCALE;
        track = make_track(&options);
        assert_sums_of_memory(track, options.reduction.sky, is_predicted ? COVERED + 2 : 1, LAST);
        toliman_track_destroy(track);
        remove_folder(folder);
        mkdir(folder, 0777);
    }
}

TEST_IN_FOLDER(setup_of_another_ledger_is_not_used) {
    char old[310];
    fill_folder(orbit, 1, LAST);
    snprintf(old, sizeof old, "%s.old", setup);
    copy_file(setup, old);
    toliman_track_destroy(rebuild(other, 0));
    assert_int_equal(rename(old, setup), 0);
    toliman_track_options options = loaded_options(TOLIMAN_TRACK_READ_ONLY);
    assert_int_equal(options.grid.nf, 0); /* the setup counts as lost */
    toliman_track *none = NULL;
    options = options_without_setup();
    assert_invalid(toliman_track_create(&options, &none), "options->reduction.sky");
}

/* Frames, repeats, a quarantined and two rejected frames. */
static void fill_mixed(const toliman_track_options *options) {
    toliman_track *const track = make_track(options);
    push_all_exposed(track, 1, LAST);
    push_all_exposed(track, 3, 9);
    push_changed(track, 7);
    small_frame frame;
    make_exposed(&frame, LAST + 1);
    frame.pixels[3] = 5000;
    for (int i = 0; i < 2; i++)
        assert_int_equal(push_one(track, &frame.frame).reason, TOLIMAN_TRACK_REASON_OVER_RANGE);
    assert_ok(toliman_track_save(track));
    push_all_exposed(track, 1, 2);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
}

static void assert_same_counts(toliman_track_info a, toliman_track_info b) {
    a.flags = b.flags = 0;
    a.committed = b.committed = 0;
    a.capacity = b.capacity = 0;
    a.system = b.system = NULL;
    assert_memory_equal(&a, &b, sizeof a);
}

/* Also with a torn record, which is removed. */
/* promise: rebuilds-equal-new-folders */
TEST_IN_FOLDER(rebuild_reduces_a_plain_folder) {
    char first[300];
    snprintf(first, sizeof first, "%s/first", folder);
    const toliman_track_options plain = measured_options(folder), reduced = reduced_options(first, orbit);
    fill_mixed(&plain);
    fill_mixed(&reduced);
    write_at(ledger, size_of(ledger), "torn", 4);
    toliman_track *const expected = make_track(&reduced);
    for (int pass = 0; pass < 2; pass++) {
        toliman_track *track = rebuild(orbit, SCALE);
        assert_same_periods(period_of(track), period_of(expected));
        assert_same_counts(assert_counted(track), assert_counted(expected));
        assert_int_equal(info_of(track).rejected_for[TOLIMAN_TRACK_REASON_OVER_RANGE - TOLIMAN_TRACK_REASON_NONE], 2);
        toliman_track_destroy(track);
        track = open_reader();
        assert_same_periods(period_of(track), period_of(expected));
        toliman_track_destroy(track), toliman_track_destroy(rebuild(other, 0));
    }
    toliman_track_destroy(expected);
    remove_folder(first);
}

/* Nothing is rewritten if the ledger has no separations. */
TEST_IN_FOLDER(rebuild_needs_separations) {
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_range(track, 1, 20);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    const uint64_t salt = number_at(ledger, 8, 8);
    options = loaded_options(TOLIMAN_TRACK_REBUILD);
    options.reduction.sky = orbit;
    options.reduction.plate_scale_arcsec = SCALE;
    assert_invalid(toliman_track_create(&options, &track), "options->reduction.sky");
    assert_true(number_at(ledger, 8, 8) == salt);
    track = open_reader();
    assert_int_equal(info_of(track).accepted + info_of(track).outlier, 20);
    toliman_track_destroy(track);
}

/* Frames that a file does not cover keep their reduction if the system is the same, with any plate scale. */
TEST_IN_FOLDER(rebuild_keeps_reductions_of_the_system) {
    fill_folder(orbit, 1, LAST);
    toliman_track_destroy(rebuild(predicted, 0));
    toliman_track *track = rebuild(predicted, 2 * SCALE);
    assert_int_equal(assert_counted(track).unreduced, 0);
    toliman_track_destroy(track);
    track = rebuild(NULL, SCALE); /* the reductions do not depend on the plate scale */
    int32_t elements[7];
    toliman_period *const sum = clean_reduced(predicted, elements);
    for (int64_t id = 1; id <= LAST; id++)
        push_by_hand(sum, id < COVERED ? predicted : orbit, elements, id);
    assert_same_periods(period_of(track), sum);
    toliman_period_destroy(sum), toliman_track_destroy(track), toliman_track_destroy(rebuild(other, 0));
    track = rebuild(predicted, 0); /* no reduction to this system is known after COVERED */
    assert_int_equal(assert_counted(track).unreduced,
                     records_with(track, TOLIMAN_TRACK_VERDICT_UNREDUCED, TOLIMAN_TRACK_REASON_NO_ORBIT));
    assert_true(info_of(track).unreduced >= LAST - COVERED - 2);
    toliman_track_destroy(track);
}

/* promise: folders-merge-in-any-order */
TEST_IN_FOLDER(shards_merge_in_any_order) {
    enum { SHARDS = 3, EACH = LAST / SHARDS };
    char shards[SHARDS][300];
    for (int i = 0; i < SHARDS; i++) {
        snprintf(shards[i], sizeof shards[i], "%s/shard%d", folder, i);
        const toliman_track_options options = reduced_options(shards[i], orbit);
        fill_with(&options, i * EACH + 1, (i + 1) * EACH + 2); /* overlapping */
    }
    for (int order = 0; order < SHARDS; order++) {
        const toliman_track_options memory = reduced_options(NULL, orbit);
        toliman_track *const track = make_track(&memory);
        for (int i = 0; i < SHARDS; i++)
            assert_ok(toliman_track_merge(track, shards[(i + order) % SHARDS], 0, NULL));
        assert_sums_by_hand(track, orbit, LAST + 2, 0);
        assert_int_equal(assert_counted(track).received, SHARDS * (EACH + 2));
        toliman_track_destroy(track);
    }
    toliman_track_options again = TOLIMAN_TRACK_OPTIONS_INIT; /* the intervals came with the merged records */
    const toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *track = make_track(&options);
    for (int i = 0; i < SHARDS; i++)
        assert_ok(toliman_track_merge(track, shards[i], 0, NULL));
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    track = rebuild(other, 0);
    assert_int_equal(toliman_track_merge(track, shards[0], 0, NULL), TOLIMAN_E_MISMATCH);
    toliman_track_destroy(track);
    for (int i = 0; i < SHARDS; i++) {
        assert_ok(toliman_track_load_options(shards[i], &again));
        again.flags = TOLIMAN_TRACK_REBUILD;
        again.reduction.sky = other;
        toliman_track_destroy(make_track(&again));
    }
    track = rebuild(other, 0);
    assert_sums_by_hand(track, other, LAST + 2, 0);
    const int64_t repeated = info_of(track).repeated;
    assert_ok(toliman_track_merge(track, shards[1], 0, NULL)); /* has another salt since: its frames arrive again */
    assert_sums_by_hand(track, other, LAST + 2, 0);
    assert_int_equal(assert_counted(track).repeated, repeated + EACH + 2);
    assert_ok(toliman_track_merge(track, shards[1], 0, NULL));
    assert_int_equal(info_of(track).repeated, repeated + EACH + 2);
    toliman_track_destroy(track);
    for (int i = 0; i < SHARDS; i++)
        remove_folder(shards[i]);
}

/* The first interval record, of frame 1, is damaged. */
TEST_IN_FOLDER(salvaged_frames_keep_values_without_intervals) {
    char damaged[300];
    snprintf(damaged, sizeof damaged, "%s/damaged", folder);
    const toliman_track_options there = reduced_options(damaged, orbit), here = reduced_options(folder, orbit);
    fill_with(&there, 1, LAST);
    char path[320];
    snprintf(path, sizeof path, "%s/ledger.tlml", damaged);
    flip_byte(path, 124 + REDUCED_COLUMNS * 64 + 60);
    toliman_track *track = make_track(&here);
    assert_fails(toliman_track_merge(track, damaged, 0, NULL), TOLIMAN_E_LOST,
                 "0 valid records, but the checkpoint counts 40");
    int64_t lost = 0;
    assert_ok(toliman_track_merge(track, damaged, TOLIMAN_TRACK_SALVAGE, &lost));
    assert_int_equal(lost, 1);
    assert_sums_by_hand(track, orbit, LAST, 0);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    track = rebuild(orbit, 0); /* the reduction is that of the system */
    assert_sums_by_hand(track, orbit, LAST, 0);
    toliman_track_destroy(track);
    for (int pass = 0; pass < 2; pass++) { /* also rebuilt a second time */
        track = rebuild(pass == 0 ? other : orbit, 0);
        assert_sums_by_hand(track, pass == 0 ? other : orbit, LAST, 1);
        assert_int_equal(records_with(track, TOLIMAN_TRACK_VERDICT_UNREDUCED, TOLIMAN_TRACK_REASON_NO_INTERVALS), 1);
        assert_int_equal(assert_counted(track).unreduced, 1);
        toliman_track_destroy(track);
    }
    remove_folder(damaged);
}

static void assert_locked(void) {
    const toliman_track_options options = reduced_options(folder, orbit);
    toliman_track *none = NULL;
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_STATE, folder);
    assert_null(none);
}

static void try_to_write(int32_t level, const char *message, void *calls) {
    (void)level;
    (void)message;
    ++*(int *)calls;
    assert_locked();
}

/* Warnings arrive before the ledger is replaced (the torn record), and after it (the lost names). */
TEST_IN_FOLDER(lock_moves_to_the_new_ledger) {
    char names[300];
    snprintf(names, sizeof names, "%s/streams.txt", folder);
    fill_folder(orbit, 1, LAST);
    const uint64_t salt = number_at(ledger, 8, 8);
    assert_int_equal(truncate(names, 0), 0);
    write_at(ledger, size_of(ledger), "torn", 4);
    toliman_track *const reader = open_reader();
    toliman_track_options options = loaded_options(TOLIMAN_TRACK_REBUILD);
    int calls = 0;
    options.log = try_to_write;
    options.log_data = &calls;
    options.reduction.sky = other;
    toliman_track *const track = make_track(&options);
    assert_int_equal(calls, 2);
    assert_true(number_at(ledger, 8, 8) != salt);
    assert_locked();
    assert_sums_by_hand(reader, orbit, LAST, 0); /* still reads the old ledger */
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    assert_ok(toliman_track_query_fit(reader, &peak));
    toliman_track_destroy(reader), toliman_track_destroy(track);
    toliman_track *const again = open_reader();
    assert_sums_by_hand(again, other, LAST, 0);
    toliman_track_destroy(again);
}

/* Runs in two processes at once. */
static void rebuild_often(const toliman_sky *sky) {
    for (int made = 0; made < 5;) {
        toliman_track_options options = reduced_options(folder, sky);
        options.flags = TOLIMAN_TRACK_REBUILD;
        toliman_track *track = NULL;
        const toliman_status status = toliman_track_create(&options, &track);
        assert_true(status == TOLIMAN_OK || status == TOLIMAN_E_STATE);
        made += status == TOLIMAN_OK;
        toliman_track_destroy(track);
        usleep(1000);
    }
}

TEST_IN_FOLDER(processes_rebuild_in_turn) {
    fill_folder(orbit, 1, LAST);
    const pid_t child = fork();
    if (child == 0) {
        rebuild_often(other);
        _exit(0);
    }
    rebuild_often(orbit);
    int status = 1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    toliman_track *track = open_reader();
    assert_int_equal(assert_counted(track).received, LAST);
    toliman_track *const expected = reduced_in_memory(orbit, 1, LAST);
    const int is_orbit = strcmp(info_of(track).system, info_of(expected).system) == 0;
    toliman_track_destroy(expected);
    assert_sums_by_hand(track, is_orbit ? orbit : other, LAST, 0);
    toliman_track_destroy(track);
    track = rebuild(orbit, 0);
    assert_sums_by_hand(track, orbit, LAST, 0);
    toliman_track_destroy(track);
}

RUN_TESTS(make_skies, destroy_skies)
