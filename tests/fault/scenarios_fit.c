/* fit.h */
#include "assert_close.h"
#include "images.h"
#include "scenario.h"

static const toliman_fit_prediction shifted[FRAMES] = {{.struct_size = sizeof *shifted, .x_px = 0.25}};

static toliman_status create_with(const char *names, void **out) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = names, .capture_px = 3, .threads = 1};
    return toliman_fit_create((const toliman_sim *[]){small_sim()}, NULL, 1, &options, (toliman_fit **)out);
}

static void *make(void) {
    void *fit = NULL;
    assert_ok(create_with("scale", &fit));
    return fit;
}

static const toliman_fit *fitter(void) {
    static void *fit;
    return fit != NULL ? fit : (fit = make());
}

static void end(void *fit) {
    toliman_fit_destroy(fit);
}

static uint64_t digest(const void *fit) {
    toliman_fit_result result = {.struct_size = sizeof result};
    toliman_fit_info info = {.struct_size = sizeof info};
    assert_ok(toliman_fit_get_info(fit, &info));
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(small_frames()), 1, NULL, &result, NULL, NULL));
    return fnv1a(fnv1a(FNV_START, &info, sizeof info), &result, sizeof result);
}

static const object_kind fits = {end, digest};

static toliman_status create(attempt *a) {
    return create_with("scale", &a->made);
}
static toliman_status create_windows(attempt *a) {
    const toliman_fit_options options = {.struct_size = sizeof options, .free = "scale", .capture_px = 3, .threads = 1};
    const toliman_sim *const sims[] = {small_sim(), small_sim()};
    static const double starts[] = {0, 1};
    return toliman_fit_create(sims, starts, 2, &options, (toliman_fit **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_fit_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status get_parameters(attempt *a) {
    size_t count = 0;
    return toliman_fit_get_parameters(fitter(), (void *)a->out, 16, &count);
}
static toliman_status get_info(attempt *a) {
    return toliman_fit_get_info(fitter(), (void *)a->out);
}
static toliman_status frame(attempt *a) {
    double *const numbers = (double *)(a->out + 1024);
    return toliman_fit_frame(fitter(), PLAIN_IMAGE(small_frames()), 1, shifted, (void *)a->out, numbers, numbers + 8);
}
static toliman_status many_frames(attempt *a) {
    double *const numbers = (double *)(a->out + 8192);
    return toliman_fit_frame(fitter(), PLAIN_IMAGE(small_frames()), FRAMES, shifted, (void *)a->out, numbers,
                             numbers + 8 * FRAMES);
}
static toliman_status predict(attempt *a) {
    double *const numbers = (double *)a->out;
    return toliman_fit_predict(fitter(), shifted, numbers, SMALL, numbers + SMALL * SMALL, NULL);
}

static void put_frames(void) {
    (void)small_frames();
    (void)fitter();
}

enum { RESULT = sizeof(toliman_fit_result) };

static const scenario all[] = {
    {.function = "toliman_fit_create", .call = create, .made = &fits, .stage = put_frames},
    {.function = "toliman_fit_create", "windows", create_windows, .made = &fits, .stage = put_frames},
    {.function = "toliman_fit_destroy", .call = destroy, .make = make, .of = &fits},
    {.function = "toliman_fit_get_parameters",
     .call = get_parameters,
     .stage = put_frames,
     .struct_size = sizeof(toliman_sim_parameter)},
    {.function = "toliman_fit_get_info",
     .call = get_info,
     .stage = put_frames,
     .struct_size = sizeof(toliman_fit_info)},
    {.function = "toliman_fit_frame",
     .call = frame,
     .stage = put_frames,
     .struct_size = RESULT,
     .allocates_nothing = 1},
    {.function = "toliman_fit_frame", "many", many_frames, .stage = put_frames, .struct_size = RESULT},
    {.function = "toliman_fit_predict", .call = predict, .stage = put_frames, .allocates_nothing = 1},
};
SCENARIO_LIST(fit_scenarios, all);
