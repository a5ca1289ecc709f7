/* Tests that frames in any order, with losses, duplicates and damage, and in any shards, give the bits of the frames
 * that should be accepted, and exact counts. TOLIMAN_SEEDS sets the number of random passes. */
#include "track_frames.h"

enum { FRAMES = 200, MOST_ARRIVALS = 3 * FRAMES };

struct pass {
    small_frame arrivals[MOST_ARRIVALS];
    int count;
    toliman_track_info expected;
    int64_t rejected[TOLIMAN_TRACK_REASON_ESTIMATE - TOLIMAN_TRACK_REASON_NONE + 1]; /* one per reject reason */
    toliman_period *clean;
};

static small_frame *arrive(struct pass *pass, int64_t id) {
    small_frame *frame = &pass->arrivals[pass->count++];
    make_frame(frame, id);
    return frame;
}

/* One kind of detectable damage. */
static void arrive_damaged(struct pass *pass, int64_t id, uint64_t *random) {
    small_frame *frame = arrive(pass, id);
    const int64_t at = (int64_t)draw(random, PIXELS / 2);
    int32_t reason = TOLIMAN_TRACK_REASON_OVER_RANGE;
    switch (draw(random, 3)) {
    case 0:
        frame->pixels[at] |= 0x8000;
        break;
    case 1:
        memset(frame->pixels + at, 0, PIXELS);
        reason = TOLIMAN_TRACK_REASON_ZERO_RUN;
        break;
    default:
        frame->frame.rows = 1 + (int64_t)draw(random, SIDE - 1);
        reason = TOLIMAN_TRACK_REASON_SHAPE;
    }
    pass->rejected[reason - TOLIMAN_TRACK_REASON_NONE]++;
    pass->expected.rejected++;
}

static void swap_arrivals(struct pass *pass, uint64_t i, uint64_t k) {
    const small_frame other = pass->arrivals[i];
    pass->arrivals[i] = pass->arrivals[k];
    pass->arrivals[k] = other;
}

/* 5 % of the frames are lost, 10 % damaged (detectably, or silently in one of two copies), 10 % duplicated, 10 % out of
 * order. */
static void make_pass(struct pass *pass, const toliman_track_options *options, uint64_t seed) {
    uint64_t random = mixed(seed);
    memset(&pass->expected, 0, sizeof pass->expected);
    memset(pass->rejected, 0, sizeof pass->rejected);
    pass->count = 0;
    pass->clean = clean_period(options);
    toliman_track_info *expected = &pass->expected;
    int64_t first = FRAMES, last = 0;
    for (int64_t id = 1; id <= FRAMES; id++) {
        if (draw(&random, 20) == 0)
            continue;
        const uint64_t kind = draw(&random, 20);
        if (kind == 0) { /* a silent flip in the first or the second of two copies */
            const uint64_t flipped = draw(&random, 2);
            for (uint64_t copy = 0; copy < 2; copy++)
                arrive(pass, id)->pixels[draw(&random, PIXELS)] ^= (uint16_t)(copy == flipped ? 1 : 0);
            expected->quarantined++;
            expected->repeated++;
        } else {
            if (kind == 1)
                arrive_damaged(pass, id, &random);
            if (kind == 1 && draw(&random, 2) == 0)
                continue; /* and no valid copy arrives */
            const small_frame *frame = arrive(pass, id);
            push_clean(pass->clean, id);
            (*(fabs(value_of_frame(frame)) <= VALUE_LIMIT ? &expected->accepted : &expected->outlier))++;
            for (; draw(&random, 10) == 0 && pass->count < MOST_ARRIVALS - 2 * (FRAMES - id) - 2; expected->repeated++)
                arrive(pass, id);
        }
        first = id < first ? id : first;
        last = id;
    }
    for (int i = 0; i < pass->count / 10; i++)
        swap_arrivals(pass, draw(&random, (uint64_t)pass->count), draw(&random, (uint64_t)pass->count));
    expected->received = pass->count;
    expected->expected = last - first + 1;
    expected->missing = expected->expected - expected->accepted - expected->outlier - expected->quarantined;
    for (int i = 0; i < pass->count; i++)
        pass->arrivals[i].frame.pixels = pass->arrivals[i].pixels;
}

static void push_pass(toliman_track *track, const struct pass *pass, uint64_t *random) {
    static toliman_track_outcome outcomes[40];
    outcomes[0].struct_size = sizeof *outcomes;
    toliman_frame batch[40];
    for (int from = 0; from < pass->count;) {
        const int most = 1 + (int)draw(random, 40), left = pass->count - from, count = most < left ? most : left;
        for (int i = 0; i < count; i++)
            batch[i] = pass->arrivals[from + i].frame;
        size_t done;
        assert_ok(toliman_track_push(track, batch, (size_t)count, outcomes, &done));
        from += count;
    }
}

static void assert_counts(const toliman_track *track, const struct pass *pass) {
    const toliman_track_info found = info_of(track), *info = &found, *expected = &pass->expected;
    for (int32_t reason = TOLIMAN_TRACK_REASON_NONE; reason <= TOLIMAN_TRACK_REASON_ESTIMATE; reason++)
        assert_int_equal(info->rejected_for[reason - TOLIMAN_TRACK_REASON_NONE],
                         pass->rejected[reason - TOLIMAN_TRACK_REASON_NONE]);
    assert_int_equal(info->received, expected->received);
    assert_int_equal(info->accepted, expected->accepted);
    assert_int_equal(info->outlier, expected->outlier);
    assert_int_equal(info->quarantined, expected->quarantined);
    assert_int_equal(info->repeated, expected->repeated);
    assert_int_equal(info->rejected, expected->rejected);
    assert_int_equal(info->expected, expected->expected);
    assert_int_equal(info->missing, expected->missing);
}

/* promises: arrival-order-changes-no-bit, frames-count-once, quarantines-retract-exactly */
TEST(any_order_gives_the_same_bits) {
    static struct pass pass;
    const char *given = getenv("TOLIMAN_SEEDS");
    const toliman_track_options options = small_options(NULL);
    const uint64_t seeds = given != NULL ? (uint64_t)atoll(given) : 300;
    for (uint64_t seed = 0; seed < seeds; seed++) {
        make_pass(&pass, &options, seed);
        uint64_t random = mixed(seed + 1000000);
        toliman_track *track = make_track(&options);
        push_pass(track, &pass, &random);
        assert_counts(track, &pass);
        assert_same_periods(period_of(track), pass.clean);
        toliman_track_destroy(track), toliman_period_destroy(pass.clean);
    }
}

/* A pass that is replayed, before and after reopening: only the count of repeats changes. */
/* promise: frames-count-once */
TEST(replays_change_nothing) {
    static struct pass pass;
    char folder[256];
    make_folder(folder, sizeof folder);
    toliman_track_options options = small_options(folder);
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    make_pass(&pass, &options, 3);
    uint64_t random = 5;
    for (int replay = 1; replay <= 10; replay++) {
        toliman_track *track = make_track(&options);
        push_pass(track, &pass, &random);
        const toliman_track_info info = info_of(track);
        assert_int_equal(info.received, replay * pass.count);
        assert_int_equal(info.accepted, pass.expected.accepted);
        assert_int_equal(info.quarantined, pass.expected.quarantined);
        assert_int_equal(info.missing, pass.expected.missing);
        assert_same_periods(period_of(track), pass.clean);
        assert_ok(toliman_track_save(track));
        toliman_track_destroy(track);
    }
    toliman_period_destroy(pass.clean);
    remove_folder(folder);
}

/* The arrivals of a pass are distributed over folders, and these merged in a random order, one of them twice. */
static void merge_shards(const struct pass *pass, int shards) {
    char above[256], path[300];
    static char paths[64][300];
    make_folder(above, sizeof above);
    uint64_t random = (uint64_t)shards;
    for (int shard = 0; shard < shards; shard++) {
        snprintf(paths[shard], sizeof paths[shard], "%s/%d", above, shard);
        toliman_track_options options = small_options(paths[shard]);
        options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
        toliman_track *track = make_track(&options);
        for (int i = 0; i < pass->count; i++)
            if (mixed((uint64_t)i * 64 + (uint64_t)shards) % (uint64_t)shards == (uint64_t)shard)
                push_one(track, &pass->arrivals[i].frame);
        assert_ok(toliman_track_save(track));
        toliman_track_destroy(track);
    }
    snprintf(path, sizeof path, "%s/out", above);
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_load_options(paths[0], &options));
    options.folder = path; /* needs no estimator */
    toliman_track *track = make_track(&options);
    for (int left = shards; left > 0; left--) {
        const uint64_t next = draw(&random, (uint64_t)left);
        assert_ok(toliman_track_merge(track, paths[next], 0, NULL));
        memmove(path, paths[next], sizeof path);
        memmove(paths[next], paths[left - 1], sizeof path);
        memmove(paths[left - 1], path, sizeof path);
    }
    const toliman_track_info info = info_of(track);
    assert_counts(track, pass);
    assert_same_periods(period_of(track), pass->clean);
    int64_t lost = -1;
    assert_ok(
        toliman_track_merge(track, paths[0], 0, &lost)); /* already merged: nothing is accepted or counted again */
    assert_int_equal(lost, 0);
    assert_same_periods(period_of(track), pass->clean);
    const toliman_track_info again = info_of(track);
    assert_memory_equal(&again, &info, sizeof info);
    toliman_track_destroy(track);
    for (int shard = 0; shard < shards; shard++)
        remove_folder(paths[shard]);
    snprintf(path, sizeof path, "%s/out", above);
    remove_folder(path);
    remove_folder(above);
}

/* promise: folders-merge-in-any-order */
TEST(shards_merge_in_any_order) {
    static struct pass pass;
    const toliman_track_options options = small_options(NULL);
    const int counts[] = {1, 7, 32};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        make_pass(&pass, &options, 100 + i);
        merge_shards(&pass, counts[i]);
        toliman_period_destroy(pass.clean);
    }
}

/* A growing folder that is merged repeatedly, directly and through another folder: every frame is included once, and
 * the counts are those of all folders together, in any order of the merges. */
/* promise: folders-merge-in-any-order */
TEST(growing_shards_are_merged_once) {
    char paths[3][256];
    toliman_track *tracks[3];
    toliman_track_options options = small_options(NULL);
    for (int i = 0; i < 3; i++) {
        make_folder(paths[i], sizeof paths[i]);
        options.folder = paths[i];
        tracks[i] = make_track(&options);
    }
    toliman_track *shard = tracks[0], *region = tracks[1], *mission = tracks[2];
    for (int round = 1; round <= 5; round++) {
        small_frame frame;
        for (int64_t id = 10 * round - 9; id <= 10 * round; id++)
            push_number(shard, id);
        push_number(shard, 10 * round); /* again */
        make_frame(&frame, 10 * round - 5);
        frame.pixels[3] = 5000;
        push_one(shard, &frame.frame);
        assert_ok(toliman_track_save(shard));
        assert_ok(toliman_track_merge(region, paths[0], 0, NULL));
        if (round % 2 == 0)
            assert_ok(toliman_track_merge(mission, paths[1], 0, NULL)); /* which now includes the shard */
        assert_ok(toliman_track_merge(mission, paths[0], 0, NULL));
        if (round == 3) { /* also after it is closed */
            assert_ok(toliman_track_save(mission));
            toliman_track_destroy(mission);
            mission = make_track(&options);
        }
        for (int i = 0; i < 2; i++) {
            const toliman_track_info info = info_of(i == 0 ? region : mission);
            assert_holds(i == 0 ? region : mission, &options, 1, 10 * round);
            assert_int_equal(info.accepted + info.outlier, 10 * round);
            const int by_way = i == 0 ? 0 : round - round % 2; /* rounds received through the region */
            assert_int_equal(info.received, 12 * (round + by_way));
            assert_int_equal(info.rejected, round + by_way);
            assert_int_equal(info.repeated, info.received - info.rejected - 10 * round);
        }
    }
    assert_fails(toliman_track_merge(region, paths[1], 0, NULL), TOLIMAN_E_ARGUMENT, "the tracker's own");
    /* A copy that continued separately. */
    char copy[300];
    snprintf(copy, sizeof copy, "%s-copy", paths[0]);
    copy_file(paths[0], copy);
    options.folder = copy;
    toliman_track *apart = make_track(&options);
    push_number(apart, 60);
    push_number(shard, 61);
    assert_ok(toliman_track_save(apart));
    assert_ok(toliman_track_save(shard));
    toliman_track_destroy(apart);
    assert_ok(toliman_track_merge(region, paths[0], 0, NULL));
    assert_ok(toliman_track_merge(region, copy, 0, NULL));
    assert_int_equal(info_of(region).accepted + info_of(region).outlier, 52);
    remove_folder(copy);
    toliman_track_destroy(shard), toliman_track_destroy(region), toliman_track_destroy(mission);
    for (int i = 0; i < 3; i++)
        remove_folder(paths[i]);
}

/* promise: estimators-are-not-mixed */
TEST(incompatible_shards_are_refused) {
    char folder[256], ledger[300];
    make_folder(folder, sizeof folder);
    snprintf(ledger, sizeof ledger, "%s/ledger.tlml", folder);
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_number(track, 1);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    toliman_track_options others[6];
    for (int i = 0; i < 6; i++)
        others[i] = small_options(NULL);
    others[0].estimator.id++;
    others[1].estimator.sigma *= 2;
    others[2].limits.value *= 2;
    others[3].frames.bit_depth = 0;
    others[4].frames.rows++;
    others[5].flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    for (int i = 0; i < 6; i++) {
        track = make_track(&others[i]);
        assert_refused(toliman_track_merge(track, folder, 0, NULL), TOLIMAN_E_MISMATCH, ledger);
        assert_int_equal(info_of(track).received, 0);
        toliman_track_destroy(track);
        others[i].folder = folder;
        toliman_track *none = NULL;
        assert_refused(toliman_track_create(&others[i], &none), TOLIMAN_E_MISMATCH, ledger);
    }
    options.folder = NULL;
    track = make_track(&options);
    assert_refused(toliman_track_merge(track, "/nonexistent/folder", 0, NULL), TOLIMAN_E_NOT_FOUND,
                   "/nonexistent/folder");
    toliman_track_destroy(track);
    remove_folder(folder);
}

RUN_TESTS(NULL, NULL)
