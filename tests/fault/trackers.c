/* Trackers: what the table `scenarios` names of track.h. A folder has frames 1 to 30; frames up to 44 arrive, or are
 * merged from another folder, while calls fail. One that reduces has frames 1 to 12, and frames up to 16 arrive. */
#include <stdio.h>

#include "objects.h"
#include "samples.h"
#include "track_reduced.h"

enum { SAVED_FRAMES = 20, SHARED_FRAMES = 25, HELD_REDUCED = 12, LAST_REDUCED = HELD_REDUCED + COMING_REDUCED };
static const char kMission[] = "mission", kOther[] = "other", kReduced[] = "reduced";
static const int64_t kClock[4] = {0, 0, DAY_NS, DAY_NS};

/* Options in a folder of the table's, or in memory; valid until the thread's next call. */
static toliman_track_options *in(const char *name, toliman_track_options options) {
    static _Thread_local toliman_track_options kept;
    static _Thread_local char path[300];
    kept = options;
    kept.folder = name != NULL ? path : NULL;
    kept.ledger.capacity = 100;
    kept.ledger.group = 4;
    snprintf(path, sizeof path, "%s", in_folder(name != NULL ? name : ""));
    return &kept;
}

static toliman_track_options *clocked(const char *name) {
    toliman_track_options *const options = in(name, small_options(NULL));
    options->clock.pairs = kClock;
    options->clock.count = sizeof kClock / sizeof *kClock / 2;
    return options;
}

const toliman_track_options *mission(uint32_t flags, double f0) {
    toliman_track_options *const options = clocked(kMission);
    options->flags = flags;
    options->grid.f0 = f0 != 0 ? f0 : options->grid.f0;
    return options;
}

const toliman_track_options *in_memory(void) {
    return clocked(NULL);
}

/* In memory, of an estimator of the library, on this number of threads. */
static toliman_track_options *estimated(uint32_t threads) {
    toliman_track_options *const options = clocked(NULL);
    options->estimator.estimate = NULL;
    options->frames.rows = options->frames.cols = options->frames.bit_depth = 0;
    options->threads = threads;
    return options;
}
const toliman_track_options *with_network(void) {
    toliman_track_options *const options = estimated(2);
    options->estimator.cae = shared(create_cae);
    options->frames.bit_depth = 12;
    return options;
}
const toliman_track_options *with_template(void) {
    toliman_track_options *const options = estimated(1);
    options->estimator.linear = shared(create_linear);
    return options;
}
const toliman_track_options *with_fit(uint32_t threads) {
    toliman_track_options *const options = estimated(threads);
    options->estimator.fit = shared(create_fit);
    return options;
}

/* With a system: frames are reduced while they arrive, and again by a rebuild. */
static toliman_sky *skies[SKIES];
static toliman_track *expected[SKIES][2]; /* in memory, with the frames up to HELD_REDUCED and up to LAST_REDUCED */

const toliman_track_options *reduced(int sky, uint32_t flags) {
    toliman_track_options *const options = in(kReduced, reduced_options(NULL, skies[sky]));
    options->flags = flags;
    return options;
}

static void push_range(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++)
        push_number(track, id);
}

/* A tracker's folder, made once, as records have the time of their arrival, and written for each call. */
enum { MASTER, OTHER, MASTER_REDUCED, MASTERS };

static void make_master(int which) {
    toliman_track *const track = make_track(which == MASTER_REDUCED ? reduced(ORBIT_SKY, 0) : mission(0, 0));
    const int64_t first = which == OTHER ? SHARED_FRAMES : 1;
    if (which == MASTER_REDUCED)
        push_all_exposed(track, first, HELD_REDUCED);
    else {
        push_range(track, first, which == OTHER ? LAST_FRAME : SAVED_FRAMES);
        push_number(track, first); /* a duplicate */
    }
    assert_ok(toliman_track_save(track));
    if (which == MASTER)
        push_range(track, SAVED_FRAMES + 1, HELD);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
}

static void put_tracker(int which, const char *to) {
    static const char *const names[] = {"ledger.tlml", "checkpoint.tlmc", "setup.tlms", "streams.txt"};
    enum { FILES = sizeof names / sizeof *names };
    static saved_file kept[MASTERS][FILES];
    const int is_new = kept[which][0].size == 0;
    char path[100];
    if (is_new) {
        empty_folder(which == MASTER_REDUCED ? kReduced : kMission);
        make_master(which);
    }
    for (size_t i = 0; i < FILES && is_new; i++) {
        snprintf(path, sizeof path, "%s/%s", which == MASTER_REDUCED ? kReduced : kMission, names[i]);
        keep_file(path, &kept[which][i]);
    }
    empty_folder(to);
    for (size_t i = 0; i < FILES; i++) {
        snprintf(path, sizeof path, "%s/%s", to, names[i]);
        put_file(path, &kept[which][i]);
    }
}

void put_mission(void) {
    char first;
    if (read_file("other/ledger.tlml", &first, 1) != 1)
        put_tracker(OTHER, kOther);
    put_tracker(MASTER, kMission);
}
void put_no_mission(void) {
    empty_folder(kMission);
}

void *make_mission(void) {
    put_mission();
    return make_track(mission(0, 0));
}
void *make_uncommitted(void) { /* with records that are not yet on disk */
    toliman_track *const track = make_mission();
    push_range(track, HELD + 1, HELD + 2);
    return track;
}
void *make_in_memory(void) {
    toliman_track *const track = make_track(in_memory());
    push_range(track, 1, HELD);
    return track;
}

/* The records of a tracker, without the random numbers of other ledgers in what a merge counted. */
static size_t comparable_records(const toliman_track *track, size_t count, toliman_track_record *records) {
    size_t done = 0;
    records->struct_size = sizeof *records;
    assert_ok(toliman_track_get_records(track, 0, count, records, &done));
    for (size_t i = 0; i < done; i++)
        if (records[i].verdict == TOLIMAN_TRACK_VERDICT_MERGED)
            records[i].stream = records[i].content = 0;
    return done;
}

uint64_t digest_track(const void *track) {
    static unsigned char bytes[STATE_CAPACITY];
    static toliman_track_record records[2 * LAST_FRAME];
    toliman_track_info info = info_of(track);
    size_t size = 0;
    info.system = NULL; /* a different pointer each time */
    memset(records, 0, sizeof records);
    assert_ok(toliman_period_save(period_of(track), bytes, sizeof bytes, &size));
    const uint64_t hash = fnv1a(fnv1a(FNV_START, &info, sizeof info), bytes, size);
    return fnv1a(hash, records, comparable_records(track, 2 * LAST_FRAME, records) * sizeof *records);
}

/* The frames that arrive, made in the first call, which is undisturbed; and with images of double, as the library's own
 * estimators need. */
const toliman_frame *coming(void) {
    static small_frame made[COMING];
    static toliman_frame frames[COMING];
    for (int i = 0; i < COMING && frames[COMING - 1].pixels == NULL; i++) {
        make_frame(&made[i], HELD + 1 + i);
        frames[i] = made[i].frame;
    }
    return frames;
}
const toliman_frame *coming_images(const double *images, size_t side) {
    static _Thread_local toliman_frame given[FRAMES];
    for (size_t i = 0; i < FRAMES; i++) {
        given[i] = coming()[i];
        given[i].pixel = TOLIMAN_PIXEL_F64;
        given[i].pixels = images + i * side * side;
        given[i].rows = given[i].cols = (int64_t)side;
    }
    return given;
}

static void expect_frames(const toliman_track *track) {
    toliman_period *clean = clean_period(in_memory());
    for (int64_t id = 1; id <= LAST_FRAME; id++)
        push_clean(clean, id);
    must(count_of(clean) == count_of(period_of(track)), "the number of samples differs");
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

/* After a disk error the folder is reopened; after any other error the tracker continues. What was acknowledged must be
 * there, and frames that did not get in can be pushed again. */
static void check_on(attempt *a, toliman_status status, int is_in_memory, int merged) {
    if (status == TOLIMAN_OK)
        return;
    toliman_track *track = a->object;
    const int64_t committed = info_of(track).committed;
    if (status != TOLIMAN_E_MEMORY) {
        toliman_track_destroy(track);
        track = make_track(mission(0, 0));
    }
    must(info_of(track).records >= committed && committed >= HELD, "acknowledged records are lost");
    if (merged)
        assert_ok(toliman_track_merge(track, in_folder(kOther), 0, NULL));
    else
        push_range(track, 1, LAST_FRAME);
    expect_frames(track);
    if (!is_in_memory) {
        assert_ok(toliman_track_save(track));
        const int64_t received = info_of(track).received;
        toliman_track_destroy(track);
        track = make_track(mission(0, 0));
        must(info_of(track).received == received, "reopened with different counts");
    }
    toliman_track_destroy(track);
    a->object = is_in_memory ? make_in_memory() : make_mission();
}

void check_pushed(attempt *a, toliman_status status) {
    check_on(a, status, 0, 0);
}
void check_in_memory(attempt *a, toliman_status status) {
    check_on(a, status, 1, 0);
}
void check_merged(attempt *a, toliman_status status) {
    check_on(a, status, 0, 1);
}
void check_uncommitted(attempt *a, toliman_status status) {
    if (status == TOLIMAN_E_MEMORY || status == TOLIMAN_OK)
        return;
    check_on(a, status, 0, 0);
    push_range(a->object, HELD + 1, HELD + 2);
}

/* Several threads allocate their scratch memory before any frame is accepted. */
void check_none_accepted(attempt *a, toliman_status status) {
    must(status == TOLIMAN_OK || info_of(a->object).received == 0, "frames were accepted");
}

static void prepare_reduced(void) {
    if (skies[ORBIT_SKY] != NULL)
        return;
    skies[ORBIT_SKY] = make_sky("alpha-cen", NULL, 600);
    set_base(skies[ORBIT_SKY]);
    skies[OTHER_SKY] = make_other_sky(skies[ORBIT_SKY]);
    for (int i = 0; i < 2 * SKIES; i++) {
        const toliman_track_options options = reduced_options(NULL, skies[i / 2]);
        expected[i / 2][i % 2] = make_track(&options);
        push_all_exposed(expected[i / 2][i % 2], 1, i % 2 ? LAST_REDUCED : HELD_REDUCED);
    }
}

void put_reduced(void) {
    prepare_reduced();
    put_tracker(MASTER_REDUCED, kReduced);
}
void put_no_reduced(void) {
    prepare_reduced();
    empty_folder(kReduced);
}

void *make_reduced(void) {
    put_reduced();
    return make_track(reduced(ORBIT_SKY, 0));
}

const toliman_frame *coming_reduced(void) {
    static small_frame made[COMING_REDUCED];
    static toliman_frame frames[COMING_REDUCED];
    for (int i = 0; i < COMING_REDUCED && frames[COMING_REDUCED - 1].pixels == NULL; i++) {
        make_exposed(&made[i], HELD_REDUCED + 1 + i);
        frames[i] = made[i].frame;
    }
    return frames;
}

/* Sums and system are both those of one rebuild. */
void check_reduced_again(attempt *a, toliman_status status) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    (void)a;
    assert_ok(toliman_track_load_options(in_folder(kReduced), &options));
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *const track = make_track(&options);
    const toliman_track_info info = info_of(track);
    const int sky = strcmp(info.system, info_of(expected[OTHER_SKY][0]).system) == 0 ? OTHER_SKY : ORBIT_SKY;
    must(status != TOLIMAN_OK || sky == OTHER_SKY, "the frames are not reduced again");
    must(info.received == HELD_REDUCED && info.unreduced == 0, "the counts differ");
    assert_same_periods(period_of(track), period_of(expected[sky][0]));
    toliman_track_destroy(track);
}

void check_pushed_reduced(attempt *a, toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    toliman_track *track = a->object;
    const int64_t committed = info_of(track).committed;
    if (status != TOLIMAN_E_MEMORY) {
        toliman_track_destroy(track);
        track = make_track(reduced(ORBIT_SKY, 0));
    }
    const toliman_track_info info = info_of(track);
    must(info.records >= committed && info.accepted + info.outlier >= HELD_REDUCED, "acknowledged records are lost");
    push_all_exposed(track, 1, LAST_REDUCED);
    assert_same_periods(period_of(track), period_of(expected[ORBIT_SKY][1]));
    toliman_track_destroy(track);
    a->object = make_reduced();
}
