/* track.h, with a system: frames are reduced while they arrive, and again by a rebuild. A folder has frames 1 to 12;
 * frames up to 16 arrive. */
#include "scenario.h"
#include "track_reduced.h"

#include <toliman/track_records.h>

enum { HELD = 12, LAST = 16, COMING = LAST - HELD };
enum { ORBIT, OTHER, SKIES };

static const char kMission[] = "reduced", kMaster[] = "reduced-master";
static const toliman_sky *skies[SKIES];
static toliman_track *expected[SKIES][2]; /* in memory, with the frames up to HELD and up to LAST */
static toliman_frame frames[COMING];

static toliman_track_options options_in(const char *name, int sky) {
    static char path[300];
    toliman_track_options options = reduced_options(path, skies[sky]);
    snprintf(path, sizeof path, "%s", in_folder(name));
    options.ledger.capacity = 100;
    options.ledger.group = 4;
    return options;
}

static toliman_track *in_memory(int sky, int64_t last) {
    const toliman_track_options options = reduced_options(NULL, skies[sky]);
    toliman_track *const track = make_track(&options);
    push_all_exposed(track, 1, last);
    return track;
}

static void prepare(void) {
    static small_frame made[COMING];
    if (skies[ORBIT] != NULL)
        return;
    skies[ORBIT] = make_sky("alpha-cen", NULL, 600);
    set_base(skies[ORBIT]);
    skies[OTHER] = make_other_sky(skies[ORBIT]);
    for (int sky = 0; sky < SKIES; sky++)
        for (int all = 0; all < 2; all++)
            expected[sky][all] = in_memory(sky, all ? LAST : HELD);
    for (int i = 0; i < COMING; i++) {
        make_exposed(&made[i], HELD + 1 + i);
        frames[i] = made[i].frame;
    }
    empty_folder(kMaster);
    const toliman_track_options options = options_in(kMaster, ORBIT);
    toliman_track *const track = make_track(&options);
    push_all_exposed(track, 1, HELD);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
}

static void put_mission(void) {
    prepare();
    copy_tracker(kMaster, kMission);
}

static void put_nothing(void) {
    prepare();
    empty_folder(kMission);
}

static void *make(void) {
    put_mission();
    const toliman_track_options options = options_in(kMission, ORBIT);
    return make_track(&options);
}

static toliman_status create(attempt *a) {
    const toliman_track_options options = options_in(kMission, ORBIT);
    return toliman_track_create(&options, (toliman_track **)&a->made);
}

static toliman_status get_measure(attempt *a) {
    return toliman_track_get_measure(a->object, NULL, (toliman_measure **)&a->made);
}
static toliman_status load_measure(attempt *a) {
    const toliman_measure_options options = {.struct_size = sizeof options, .kind = TOLIMAN_MEASURE_SEPARATION};
    return toliman_measure_load_file(in_folder(kMission), &options, (toliman_measure **)&a->made);
}

static toliman_status reduce_again(attempt *a) {
    toliman_track_options options = options_in(kMission, OTHER);
    options.flags = TOLIMAN_TRACK_REBUILD;
    return toliman_track_create(&options, (toliman_track **)&a->made);
}

static toliman_status push(attempt *a) {
    return toliman_track_push(a->object, frames, COMING, (void *)a->out, (size_t *)(a->out + 8192));
}

/* Of frame 1, whose record follows its intervals. */
static toliman_status get_intervals(attempt *a) {
    return toliman_track_get_intervals(a->object, 1, (double *)a->out, 256, (size_t *)(a->out + 8192));
}

/* Sums and system are both those of one rebuild. */
static void check_old_or_new(attempt *a, toliman_status status) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    (void)a;
    assert_ok(toliman_track_load_options(in_folder(kMission), &options));
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *const track = make_track(&options);
    const toliman_track_info info = info_of(track);
    const int sky = strcmp(info.system, info_of(expected[OTHER][0]).system) == 0 ? OTHER : ORBIT;
    must(status != TOLIMAN_OK || sky == OTHER, "the frames are not reduced again");
    must(info.received == HELD && info.unreduced == 0, "the counts differ");
    assert_same_periods(period_of(track), period_of(expected[sky][0]));
    toliman_track_destroy(track);
}

static void check_pushed(attempt *a, toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    toliman_track *track = a->object;
    const int64_t committed = info_of(track).committed;
    if (status != TOLIMAN_E_MEMORY) {
        const toliman_track_options options = options_in(kMission, ORBIT);
        toliman_track_destroy(track);
        track = make_track(&options);
    }
    must(info_of(track).records >= committed && info_of(track).accepted + info_of(track).outlier >= HELD,
         "acknowledged records are lost");
    push_all_exposed(track, 1, LAST);
    assert_same_periods(period_of(track), period_of(expected[ORBIT][1]));
    toliman_track_destroy(track);
    a->object = make();
}

static const scenario all[] = {
    {.function = "toliman_track_get_measure",
     .call = get_measure,
     .make = make,
     .of = &trackers,
     .made = &measures,
     .slow = 1},
    {.function = "toliman_measure_load_file",
     "state folder",
     load_measure,
     .made = &measures,
     .stage = put_mission,
     .slow = 1},
    {.function = "toliman_track_create", "reduced", create, .made = &trackers, .stage = put_nothing},
    {.function = "toliman_track_create",
     "reduced again",
     reduce_again,
     .made = &trackers,
     .stage = put_mission,
     .check = check_old_or_new},
    {.function = "toliman_track_push",
     "reduced",
     push,
     make,
     &trackers,
     .struct_size = sizeof(toliman_track_outcome),
     .partial = "track.h: on an error the first *done frames were accepted",
     .check = check_pushed},
    {.function = "toliman_track_get_intervals", NULL, get_intervals, make, &trackers},
};
SCENARIO_LIST(track_reduced_scenarios, all);
