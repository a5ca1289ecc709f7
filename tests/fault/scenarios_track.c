/* track.h. A tracker has frames 1 to 30; frames up to 44 arrive, or are merged from another folder, while calls
 * fail. */
#include <string.h>

#include "samples.h"
#include "scenario.h"
#include "track_frames.h"

enum { HELD = 30, SAVED = 20, LAST = 44, COMING = LAST - HELD, SHARED = 25, CLOCK_POINTS = 2 };

static const char kMission[] = "mission", kMaster[] = "master", kOther[] = "other";
static const int64_t kClock[2 * CLOCK_POINTS] = {0, 0, DAY_NS, DAY_NS};

static toliman_track_options options_in(const char *name) {
    static char path[300];
    toliman_track_options options = small_options(NULL);
    if (name != NULL) {
        snprintf(path, sizeof path, "%s", in_folder(name));
        options.folder = path;
    }
    options.ledger.capacity = 100;
    options.ledger.group = 4;
    options.clock.pairs = kClock;
    options.clock.count = CLOCK_POINTS;
    return options;
}

static void push_range(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++)
        push_number(track, id);
}

static void make_folder_with(const char *name, int64_t first, int64_t last, int64_t saved) {
    empty_folder(name);
    const toliman_track_options options = options_in(name);
    toliman_track *const track = make_track(&options);
    push_range(track, first, saved);
    push_number(track, first); /* a duplicate */
    assert_ok(toliman_track_save(track));
    push_range(track, saved + 1, last);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
}

static void make_folders(void) {
    static int made;
    if (made++ != 0)
        return;
    make_folder_with(kMaster, 1, HELD, SAVED);
    make_folder_with(kOther, SHARED, LAST, LAST);
}

void copy_tracker(const char *from, const char *to) {
    static const char *const names[] = {"ledger.tlml", "checkpoint.tlmc", "setup.tlms", "streams.txt"};
    static unsigned char bytes[STATE_CAPACITY];
    char path[100];
    empty_folder(to);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/%s", from, names[i]);
        const size_t size = read_file(path, bytes, sizeof bytes);
        snprintf(path, sizeof path, "%s/%s", to, names[i]);
        write_file(path, bytes, size);
    }
}

static void put_mission(void) {
    make_folders();
    copy_tracker(kMaster, kMission);
}

static void put_nothing(void) {
    make_folders();
    empty_folder(kMission);
}

static toliman_track *open_mission(void) {
    const toliman_track_options options = options_in(kMission);
    return make_track(&options);
}

static void *make(void) {
    put_mission();
    return open_mission();
}

/* With records that are not yet on disk. */
static void *make_uncommitted(void) {
    toliman_track *const track = make();
    push_range(track, HELD + 1, HELD + 2);
    return track;
}

static void *make_in_memory(void) {
    const toliman_track_options options = options_in(NULL);
    toliman_track *const track = make_track(&options);
    make_folders();
    push_range(track, 1, HELD);
    return track;
}

static void end(void *track) {
    toliman_track_destroy(track);
}

static uint64_t digest(const void *track) {
    static unsigned char bytes[STATE_CAPACITY];
    static toliman_track_record lines[2 * LAST];
    toliman_track_info info = info_of(track);
    size_t size = 0;
    info.system = NULL; /* a different pointer each time */
    memset(lines, 0, sizeof lines);
    lines->struct_size = sizeof *lines;
    assert_ok(toliman_period_save(period_of(track), bytes, sizeof bytes, &size));
    uint64_t hash = fnv1a(fnv1a(FNV_START, &info, sizeof info), bytes, size);
    assert_ok(toliman_track_get_records(track, 0, 2 * LAST, lines, &size));
    return fnv1a(hash, lines, size * sizeof *lines);
}

const object_kind trackers = {end, digest};

/* The frames that arrive. */
static toliman_frame frames[COMING];

static void fill_frames(void) {
    static small_frame made[COMING];
    for (int i = 0; i < COMING; i++) {
        make_frame(&made[i], HELD + 1 + i);
        frames[i] = made[i].frame;
    }
}

static void expect_frames(const toliman_track *track, int64_t last) {
    const toliman_track_options options = options_in(NULL);
    toliman_period *clean = clean_period(&options);
    for (int64_t id = 1; id <= last; id++)
        push_clean(clean, id);
    must(trackers.digest != NULL && count_of(clean) == count_of(period_of(track)), "the number of samples differs");
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
}

/* After a disk error the folder is reopened; after any other error the tracker continues. What was acknowledged must be
 * there, and frames that did not get in can be pushed again. */
static void check_on(attempt *a, toliman_status status, int in_memory, int merged) {
    if (status == TOLIMAN_OK)
        return;
    toliman_track *track = a->object;
    const int64_t committed = info_of(track).committed;
    if (status != TOLIMAN_E_MEMORY) {
        toliman_track_destroy(track);
        track = open_mission();
    }
    must(info_of(track).records >= committed && committed >= HELD, "acknowledged records are lost");
    if (merged)
        assert_ok(toliman_track_merge(track, in_folder(kOther), 0, NULL));
    else
        push_range(track, 1, LAST);
    expect_frames(track, LAST);
    if (!in_memory) {
        assert_ok(toliman_track_save(track));
        const int64_t received = info_of(track).received;
        toliman_track_destroy(track);
        track = open_mission();
        must(info_of(track).received == received, "reopened with different counts");
    }
    toliman_track_destroy(track);
    a->object = in_memory ? make_in_memory() : make();
}

static void check_pushed(attempt *a, toliman_status status) {
    check_on(a, status, 0, 0);
}
static void check_in_memory(attempt *a, toliman_status status) {
    check_on(a, status, 1, 0);
}
static void check_merged(attempt *a, toliman_status status) {
    check_on(a, status, 0, 1);
}
static void check_uncommitted(attempt *a, toliman_status status) {
    if (status == TOLIMAN_E_MEMORY || status == TOLIMAN_OK)
        return;
    check_on(a, status, 0, 0);
    push_range(a->object, HELD + 1, HELD + 2);
}

/* Several threads allocate their scratch memory before any frame is accepted. */
static void check_none_accepted(attempt *a, toliman_status status) {
    must(status == TOLIMAN_OK || info_of(a->object).received == 0, "frames were accepted");
}

static toliman_status create(attempt *a) {
    const toliman_track_options options = options_in(kMission);
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static toliman_status create_in_memory(attempt *a) {
    const toliman_track_options options = options_in(NULL);
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static toliman_status create_reader(attempt *a) {
    toliman_track_options options = options_in(kMission);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static toliman_status create_other_grid(attempt *a) {
    toliman_track_options options = options_in(kMission);
    options.flags = TOLIMAN_TRACK_REBUILD;
    options.grid.f0 = 0.002;
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static toliman_status create_mismatched(attempt *a) {
    toliman_track_options options = options_in(kMission);
    options.grid.f0 = 0.002;
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static toliman_status create_with_network(attempt *a) {
    static toliman_cae *cae;
    toliman_track_options options = options_in(NULL);
    if (cae == NULL)
        assert_ok(toliman_cae_create(large_sim(), 3, NULL, &cae));
    options.estimator.cae = cae;
    options.estimator.estimate = NULL;
    options.frames.rows = options.frames.cols = 0;
    options.threads = 2;
    return toliman_track_create(&options, (toliman_track **)&a->made);
}
static void *make_with_network(void) {
    attempt a = {NULL, NULL, NULL};
    assert_ok(create_with_network(&a));
    return a.made;
}
static void *make_with_template(void) {
    static toliman_linear *linear;
    toliman_track *track = NULL;
    toliman_track_options options = options_in(NULL);
    if (linear == NULL)
        assert_ok(toliman_linear_create(small_sim(), NULL, &linear));
    options.estimator.linear = linear;
    options.threads = 1;
    options.estimator.estimate = NULL;
    options.frames.rows = options.frames.cols = options.frames.bit_depth = 0;
    assert_ok(toliman_track_create(&options, &track));
    return track;
}
static void *make_with_fit(void) {
    static toliman_fit *fit;
    toliman_track *track = NULL;
    toliman_track_options options = options_in(NULL);
    if (fit == NULL)
        assert_ok(toliman_fit_create((const toliman_sim *[]){small_sim()}, NULL, 1, NULL, &fit));
    options.estimator.fit = fit;
    options.threads = 1;
    options.estimator.estimate = NULL;
    options.frames.rows = options.frames.cols = options.frames.bit_depth = 0;
    assert_ok(toliman_track_create(&options, &track));
    return track;
}
static toliman_status destroy(attempt *a) {
    toliman_track_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}

static toliman_status push(attempt *a) {
    return toliman_track_push(a->object, frames, COMING, (void *)a->out, (size_t *)(a->out + 8192));
}

/* Frames of double, as the library's own estimators need. */
static toliman_status push_images(toliman_track *track, const double *images, int64_t side, attempt *a) {
    toliman_frame given[FRAMES];
    for (int i = 0; i < FRAMES; i++) {
        given[i] = frames[i];
        given[i].pixel = TOLIMAN_PIXEL_F64;
        given[i].pixels = images + i * side * side;
        given[i].rows = given[i].cols = side;
    }
    return toliman_track_push(track, given, FRAMES, (void *)a->out, (size_t *)(a->out + 8192));
}
static toliman_status push_to_network(attempt *a) {
    return push_images(a->object, large_frames(), LARGE, a);
}
static toliman_status push_small_images(attempt *a) {
    return push_images(a->object, small_frames(), SMALL, a);
}

static toliman_status commit(attempt *a) {
    return toliman_track_commit(a->object);
}
static toliman_status save(attempt *a) {
    return toliman_track_save(a->object);
}
static toliman_status merge(attempt *a) {
    return toliman_track_merge(a->object, in_folder(kOther), 0, NULL);
}
static toliman_status salvage(attempt *a) {
    return toliman_track_merge(a->object, in_folder(kOther), TOLIMAN_TRACK_SALVAGE, (int64_t *)a->out);
}
static toliman_status load_options(attempt *a) {
    toliman_track_options *const options = (void *)a->out;
    const toliman_status status = toliman_track_load_options(in_folder(kMaster), options);
    if (status == TOLIMAN_OK)
        options->folder = NULL; /* a different pointer each time */
    return status;
}
static toliman_status get_info(attempt *a) {
    return toliman_track_get_info(a->object, (void *)a->out);
}
static toliman_status get_records(attempt *a) {
    return toliman_track_get_records(a->object, 0, LAST, (void *)a->out, (size_t *)(a->out + 65536));
}
static toliman_status get_columns(attempt *a) {
    return toliman_track_get_columns(a->object, (void *)a->out, 16, (size_t *)(a->out + 8192));
}
static toliman_status get_column(attempt *a) {
    return toliman_track_get_column(a->object, "flags", 0, LAST, (double *)a->out, (size_t *)(a->out + 65536));
}
static toliman_status get_options(attempt *a) {
    toliman_track_options *const options = (void *)a->out;
    const toliman_status status = toliman_track_get_options(a->object, options);
    if (status == TOLIMAN_OK)
        options->folder = NULL; /* a different one for each tracker */
    return status;
}
static toliman_status get_streams(attempt *a) {
    return toliman_track_get_streams(a->object, (void *)a->out, 5, (size_t *)(a->out + 8192));
}
static toliman_status get_period(attempt *a) {
    const toliman_period *period = NULL;
    const toliman_status status = toliman_track_get_period(a->object, &period);
    must(period != NULL, "get_period");
    return status;
}
static toliman_status query_fit(attempt *a) {
    return toliman_track_query_fit(a->object, (void *)a->out);
}

static toliman_status query_goodness(attempt *a) {
    return toliman_track_query_goodness(a->object, (void *)a->out);
}

static void put_frames(void) {
    make_folders();
    fill_frames();
    (void)small_frames(), (void)large_frames();
}

#define FIRST_DONE "track.h: on an error the first *done frames were accepted"
#define PARTLY_MERGED "track.h: some records may have been merged, and count again when merged again"
#define ON_DISK "track.h: records may be on disk nevertheless"
enum { OUTCOME = sizeof(toliman_track_outcome) };
#define QUERIES(name, size)                                                                                            \
    { .function = "toliman_track_" #name, .call = name, .make = make, .of = &trackers, .struct_size = size }

static const scenario all[] = {
    {.function = "toliman_track_create", "new folder", create, .made = &trackers, .stage = put_nothing},
    {.function = "toliman_track_create", "folder", create, .made = &trackers, .stage = put_mission},
    {.function = "toliman_track_create", "reader", create_reader, .made = &trackers, .stage = put_mission},
    {.function = "toliman_track_create", "other grid", create_other_grid, .made = &trackers, .stage = put_mission},
    {.function = "toliman_track_create",
     "mismatched",
     create_mismatched,
     .made = &trackers,
     .stage = put_mission,
     .refused = TOLIMAN_E_MISMATCH},
    {.function = "toliman_track_create", "in memory", create_in_memory, .made = &trackers},
    {.function = "toliman_track_create", "network", create_with_network, .made = &trackers},
    QUERIES(destroy, 0),
    {.function = "toliman_track_push",
     "folder",
     push,
     make,
     &trackers,
     .struct_size = OUTCOME,
     .partial = FIRST_DONE,
     .stage = put_frames,
     .check = check_pushed},
    {.function = "toliman_track_push",
     "in memory",
     push,
     make_in_memory,
     &trackers,
     .struct_size = OUTCOME,
     .partial = FIRST_DONE,
     .stage = put_frames,
     .check = check_in_memory},
    {.function = "toliman_track_push",
     "network",
     push_to_network,
     make_with_network,
     &trackers,
     .struct_size = OUTCOME,
     .partial = FIRST_DONE,
     .stage = put_frames,
     .check = check_none_accepted},
    {.function = "toliman_track_push",
     "template",
     push_small_images,
     make_with_template,
     &trackers,
     .struct_size = OUTCOME,
     .stage = put_frames},
    {.function = "toliman_track_push",
     "fit",
     push_small_images,
     make_with_fit,
     &trackers,
     .struct_size = OUTCOME,
     .stage = put_frames},
    {.function = "toliman_track_commit", NULL, commit, make_uncommitted, &trackers, .check = check_uncommitted},
    {.function = "toliman_track_save",
     NULL,
     save,
     make_uncommitted,
     &trackers,
     .partial = ON_DISK,
     .check = check_uncommitted},
    {.function = "toliman_track_merge", NULL, merge, make, &trackers, .partial = PARTLY_MERGED, .check = check_merged},
    {.function = "toliman_track_merge",
     "salvage",
     salvage,
     make,
     &trackers,
     .partial = PARTLY_MERGED,
     .check = check_merged},
    {.function = "toliman_track_load_options",
     .call = load_options,
     .struct_size = sizeof(toliman_track_options),
     .stage = put_frames},
    QUERIES(get_info, sizeof(toliman_track_info)),
    QUERIES(get_records, sizeof(toliman_track_record)),
    QUERIES(get_columns, sizeof(toliman_track_column)),
    QUERIES(get_column, 0),
    QUERIES(get_options, sizeof(toliman_track_options)),
    QUERIES(get_streams, sizeof(toliman_track_stream)),
    QUERIES(get_period, 0),
    QUERIES(query_fit, sizeof(toliman_period_peak)),
    QUERIES(query_goodness, sizeof(toliman_track_goodness)),
};
SCENARIO_LIST(track_scenarios, all);
