/* mask.h */
#include <string.h>

#include "assert_close.h"
#include "scenario.h"

/* Of the shortest design: one iteration of each descent. */
static toliman_mask_options options_of_design(void) {
    toliman_mask_options options = TOLIMAN_MASK_OPTIONS_INIT;
    options.threads = 1;
    options.seed = 1;
    options.iterations = 2;
    options.free = "flux_a shift_x";
    return options;
}

static void *make(void) {
    toliman_mask *mask = NULL;
    const toliman_mask_options options = options_of_design();
    assert_ok(toliman_mask_create(small_sim(), &options, &mask));
    return mask;
}

static void end(void *mask) {
    toliman_mask_destroy(mask);
}

static uint64_t digest(const void *mask) {
    const char *const json = toliman_mask_get_json(mask);
    toliman_mask_info info = {.struct_size = sizeof info};
    assert_ok(toliman_mask_get_info(mask, &info));
    return fnv1a(fnv1a(FNV_START, json, strlen(json)), &info, sizeof info);
}

static const object_kind masks = {end, digest};

static toliman_status design(attempt *a) {
    const toliman_mask_options options = options_of_design();
    return toliman_mask_create(small_sim(), &options, (toliman_mask **)&a->made);
}
static toliman_status get_place(attempt *a) {
    return toliman_mask_get_place(a->object, 0, (void *)a->out);
}
static toliman_status get_cells(attempt *a) {
    toliman_sim_info info = {.struct_size = sizeof info};
    assert_ok(toliman_sim_get_info(small_sim(), &info));
    return toliman_mask_get_cells(a->object, (size_t)info.pupil_samples, (double *)a->out);
}
static toliman_status get_descent(attempt *a) {
    toliman_mask_info info = {.struct_size = sizeof info};
    assert_ok(toliman_mask_get_info(a->object, &info));
    return toliman_mask_get_descent(a->object, (size_t)info.iterations, (double *)a->out);
}
static toliman_status destroy(attempt *a) {
    toliman_mask_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status get_info(attempt *a) {
    return toliman_mask_get_info(a->object, (void *)a->out);
}
static toliman_status get_json(attempt *a) {
    strcpy((char *)a->out, toliman_mask_get_json(a->object));
    return TOLIMAN_OK;
}

static void put_scene(void) {
    (void)small_sim();
}

static const scenario all[] = {
    {.function = "toliman_mask_create", .call = design, .made = &masks, .stage = put_scene, .slow = 1},
    {.function = "toliman_mask_get_place",
     .call = get_place,
     .make = make,
     .of = &masks,
     .struct_size = sizeof(toliman_mask_info)},
    {.function = "toliman_mask_get_cells", .call = get_cells, .make = make, .of = &masks},
    {.function = "toliman_mask_get_descent", .call = get_descent, .make = make, .of = &masks},
    {.function = "toliman_mask_destroy", .call = destroy, .make = make, .of = &masks},
    {.function = "toliman_mask_get_info",
     .call = get_info,
     .make = make,
     .of = &masks,
     .struct_size = sizeof(toliman_mask_info)},
    {.function = "toliman_mask_get_json", .call = get_json, .make = make, .of = &masks},
};
SCENARIO_LIST(mask_scenarios, all);
