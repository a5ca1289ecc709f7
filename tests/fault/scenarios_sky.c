/* sky.h */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "assert_close.h"
#include "measure_arrays.h"
#include "scenario.h"

enum { TIMES = 3 };
static const int64_t kTimes[TIMES] = {1800000000000000000, 1800050000000000000, 1900000000000000000};
static const char kSystem[] = "binary.json", kOrbit[] = "spacecraft.csv";
static const char kFolder[] = "systems", kSaved[] = "systems/saved.json";

static const char kBinary[] =
    "{\"schema\": \"toliman-system/1\", \"name\": \"a binary\", \"orbit\": {\"period_years\": 80, "
    "\"semi_major_arcsec\": 17, \"eccentricity\": 0.5, \"inclination_deg\": 79, \"node_deg\": 205, \"periastron_deg\": "
    "231, \"epoch\": 1955.5, \"source\": \"a catalogue\"}, \"barycentre\": {\"ra_deg\": 219, \"dec_deg\": -60, "
    "\"epoch\": 2019.5, \"pm_ra_mas_yr\": -3640, \"pm_dec_mas_yr\": 700, \"parallax_mas\": 750, "
    "\"radial_velocity_km_s\": -22, \"radial_velocity_kind\": \"kinematic\"}, \"masses\": {\"A\": 1.1, \"B\": 0.9}}";

static void put_system(void) {
    write_file(kSystem, kBinary, sizeof kBinary - 1);
}

/* Ten states, one per minute, of a circular orbit of 7000 km. */
static void put_observer(void) {
    char text[4000] = "t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n";
    size_t used = strlen(text);
    for (int i = 0; i < 10; i++) {
        const double angle = 0.00107801 * 60 * i, c = cos(angle), s = sin(angle);
        const int64_t tai_ns = kTimes[0] + (i - 5) * INT64_C(60000000000);
        used += (size_t)snprintf(text + used, sizeof text - used, "%lld,%.6f,%.6f,0,%.9f,%.9f,0\n", (long long)tai_ns,
                                 7000 * c, 7000 * s, -7.54607 * s, 7.54607 * c);
    }
    write_file(kOrbit, text, used);
    put_system();
}

static toliman_status create_of(const char *system, const char *observer, void **out) {
    const toliman_sky_options options = {
        .struct_size = sizeof options, .observer = observer, .altitude_km = observer != NULL ? 0 : 600};
    return toliman_sky_create(system, &options, (toliman_sky **)out);
}

static void *make(void) {
    void *made = NULL;
    assert_ok(create_of("alpha-cen", NULL, &made));
    return made;
}

static void *make_with_observer(void) {
    void *made = NULL;
    put_observer();
    assert_ok(create_of(in_folder(kSystem), in_folder(kOrbit), &made));
    return made;
}

static void end(void *made) {
    toliman_sky_destroy(made);
}

static uint64_t digest(const void *made) {
    toliman_sky_info info = {.struct_size = sizeof info};
    toliman_sky_prediction seen[TIMES] = {{.struct_size = sizeof *seen}};
    double numbers[2 * TOLIMAN_SKY_ELEMENTS];
    assert_ok(toliman_sky_get_info(made, &info));
    assert_ok(toliman_sky_predict(made, kTimes, info.observer == TOLIMAN_SKY_OBSERVER_FILE ? 1 : TIMES, seen));
    for (int32_t i = 0; i < (int32_t)TOLIMAN_SKY_ELEMENTS; i++)
        assert_ok(toliman_sky_get_element(made, TOLIMAN_SKY_ELEMENT_PERIOD + i, &numbers[2 * i], &numbers[2 * i + 1]));
    return fnv1a(fnv1a(fnv1a(FNV_START, &info, sizeof info), seen, sizeof seen), numbers, sizeof numbers);
}

static const object_kind skies = {end, digest};

static toliman_status create(attempt *a) {
    return create_of("alpha-cen", NULL, &a->made);
}
static toliman_status create_from_file(attempt *a) {
    return create_of(in_folder(kSystem), NULL, &a->made);
}
static toliman_status create_with_observer(attempt *a) {
    return create_of(in_folder(kSystem), in_folder(kOrbit), &a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_sky_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status predict(attempt *a) {
    return toliman_sky_predict(a->object, kTimes, TIMES, (void *)a->out);
}
static toliman_status predict_mean(attempt *a) {
    const int64_t intervals[] = {kTimes[0], kTimes[0] + 60, kTimes[0] + 600, kTimes[0] + 700};
    const size_t counts[] = {2};
    return toliman_sky_predict_mean(a->object, intervals, counts, 1, (void *)a->out);
}
/* One measurement, of which the file of make_with_observer has no state, and two others. */
static toliman_status reduce(attempt *a) {
    static const double measured[TIMES] = {9.8, 9.9, 10};
    int64_t intervals[2 * TIMES];
    for (int i = 0; i < TIMES; i++) {
        intervals[2 * i] = kTimes[0] + (i == 1 ? INT64_C(86400000000000) : 0);
        intervals[2 * i + 1] = intervals[2 * i] + INT64_C(60000000000);
    }
    static toliman_measure *series;
    if (series == NULL)
        assert_ok(measure_separations(intervals, NULL, measured, NULL, TIMES, &series));
    return toliman_sky_reduce(a->object, series, NULL, (toliman_measure **)&a->made);
}
static toliman_status get_info(attempt *a) {
    return toliman_sky_get_info(a->object, (void *)a->out);
}
static toliman_status get_element(attempt *a) {
    return toliman_sky_get_element(a->object, TOLIMAN_SKY_ELEMENT_ECCENTRICITY, (double *)a->out, (double *)a->out + 1);
}
static toliman_status set_columns(attempt *a) {
    static const toliman_period_options defaults = TOLIMAN_PERIOD_OPTIONS_INIT;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    const toliman_status status =
        toliman_sky_set_columns(a->object, 1, 1e-3, &options, (int32_t *)(a->out + sizeof options));
    if (memcmp(&options, &defaults, sizeof options) != 0)
        memcpy(a->out, &options, sizeof options);
    return status;
}
static toliman_status element_name(attempt *a) {
    strcpy((char *)a->out, toliman_constant_name(TOLIMAN_SKY_ELEMENT_INCLINATION));
    return TOLIMAN_OK;
}
enum { DATES = 12 };
static toliman_status refit(attempt *a) {
    const toliman_sky *const sky = a->object;
    int64_t intervals[2 * DATES];
    double separations[DATES], sigmas[DATES];
    static const double expected[DATES] = {9.2, 9.3, 9.4, 9.5, 9.6, 9.7, 9.8, 9.9, 10.0, 10.1, 10.1, 10.2};
    for (int i = 0; i < DATES; i++) {
        intervals[2 * i] = kTimes[0] + i * INT64_C(8000000000000000);
        intervals[2 * i + 1] = intervals[2 * i] + INT64_C(60000000000);
        separations[i] = expected[i];
        sigmas[i] = 1;
    }
    static toliman_measure *series;
    if (series == NULL)
        assert_ok(measure_separations(intervals, NULL, separations, sigmas, DATES, &series));
    return toliman_sky_refit(sky, series, 1e-3, (void *)a->out, (toliman_sky **)&a->made);
}
static toliman_status diagnose(attempt *a) {
    int64_t intervals[2 * 3 * DATES];
    double separations[3 * DATES], sigmas[3 * DATES];
    for (int i = 0; i < 3 * DATES; i++) {
        intervals[2 * i] = kTimes[0] + i * INT64_C(2600000000000000);
        intervals[2 * i + 1] = intervals[2 * i] + INT64_C(60000000000);
        separations[i] = 9.2 + 0.03 * i;
        sigmas[i] = 1;
    }
    toliman_sky_hypothesis hypotheses[TOLIMAN_SKY_HYPOTHESES] = {TOLIMAN_SKY_HYPOTHESIS_INIT};
    static toliman_measure *series;
    if (series == NULL)
        assert_ok(measure_separations(intervals, NULL, separations, sigmas, 3 * DATES, &series));
    const toliman_status status = toliman_sky_diagnose(a->object, series, 1e-3, (void *)a->out, hypotheses);
    if (status == TOLIMAN_OK)
        memcpy(a->out + sizeof(toliman_sky_diagnosis), hypotheses, sizeof hypotheses);
    return status;
}
static toliman_status save_file(attempt *a) {
    return toliman_sky_save_file(a->object, in_folder(kSaved));
}
static void put_old(void) {
    empty_folder(kFolder);
    write_file(kSaved, "old", 3);
}
static void check_saved(attempt *a, toliman_status status) {
    (void)a;
    must_be_old_or_new(kFolder, kSaved, "\"toliman-system/1\"", status);
}

static const scenario all[] = {
    {.function = "toliman_sky_create", .call = create, .made = &skies},
    {.function = "toliman_sky_create",
     .variant = "from a file",
     .call = create_from_file,
     .made = &skies,
     .stage = put_system},
    {.function = "toliman_sky_create",
     .variant = "with an observer file",
     .call = create_with_observer,
     .made = &skies,
     .stage = put_observer},
    {.function = "toliman_sky_destroy", .call = destroy, .make = make, .of = &skies},
    {.function = "toliman_sky_predict",
     .call = predict,
     .make = make,
     .of = &skies,
     .struct_size = sizeof(toliman_sky_prediction)},
    {.function = "toliman_sky_predict_mean",
     .call = predict_mean,
     .make = make,
     .of = &skies,
     .struct_size = sizeof(toliman_sky_prediction)},
    {.function = "toliman_sky_reduce", .call = reduce, .make = make_with_observer, .of = &skies, .made = &measures},
    {.function = "toliman_sky_get_info",
     .call = get_info,
     .make = make,
     .of = &skies,
     .struct_size = sizeof(toliman_sky_info)},
    {.function = "toliman_sky_get_element", .call = get_element, .make = make, .of = &skies},
    {.function = "toliman_sky_set_columns", .call = set_columns, .make = make, .of = &skies},
    {.function = "toliman_sky_refit",
     .call = refit,
     .make = make,
     .of = &skies,
     .made = &skies,
     .struct_size = sizeof(toliman_sky_refit_result),
     .slow = 1},
    {.function = "toliman_sky_diagnose",
     .call = diagnose,
     .make = make,
     .of = &skies,
     .struct_size = sizeof(toliman_sky_diagnosis),
     .slow = 1},
    {.function = "toliman_sky_save_file",
     .call = save_file,
     .make = make,
     .of = &skies,
     .stage = put_old,
     .check = check_saved,
     .slow = 1},
    {.function = "toliman_constant_name", .call = element_name},
};
SCENARIO_LIST(sky_scenarios, all);
