/* measure.h */
#include <string.h>

#include "measure_arrays.h"
#include "scenario.h"

enum { SAMPLES = 20 };
static const char kText[] = "separations.csv";

static double t[SAMPLES], y[SAMPLES];
static int64_t intervals[2 * SAMPLES];
static size_t counts[SAMPLES];

static void fill(void) {
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = 61041 + 3.5 * i;
        y[i] = 9.8 + 1e-3 * i;
        intervals[2 * i] = INT64_C(1800000000000000000) + i * INT64_C(300000000000000);
        intervals[2 * i + 1] = intervals[2 * i] + INT64_C(60000000000);
        counts[i] = 1;
    }
}

static void *make(void) {
    toliman_measure *made = NULL;
    fill();
    assert_ok(measure_separations(intervals, counts, y, y, SAMPLES, &made));
    assert_ok(toliman_measure_add_column(made, "c", t, SAMPLES, 1));
    return made;
}

static void end(void *made) {
    toliman_measure_destroy(made);
}

static uint64_t digest(const void *made) {
    toliman_measure_info info = {.struct_size = sizeof info};
    double values[64];
    assert_ok(toliman_measure_get_info(made, &info));
    uint64_t hash = fnv1a(FNV_START, &info, sizeof info);
    assert_true(info.n <= 64);
    assert_ok(toliman_measure_get_values(made, "y", values, (size_t)info.n));
    hash = fnv1a(hash, values, (size_t)info.n * sizeof *values);
    for (int64_t f = 0; f < info.functions; f++) {
        toliman_measure_function function = {.struct_size = sizeof function};
        assert_ok(toliman_measure_get_function(made, f, &function));
        hash = fnv1a(hash, &function, sizeof function);
    }
    return hash;
}

const object_kind measures = {end, digest};

static void put_text(void) {
    static const char text[] = "mjd,y,sigma\n61041.5,9.8,1e-6\n61042.5,9.9,1e-6\n61043.5,9.8,2e-6\n";
    write_file(kText, text, sizeof text - 1);
}

static toliman_status create(attempt *a) {
    fill();
    return measure_separations(intervals, counts, y, y, SAMPLES, (toliman_measure **)&a->made);
}
static toliman_status load(attempt *a) {
    static const char text[] = "1,2\n2,3\n3,4\n";
    return toliman_measure_load(text, sizeof text - 1, "text", NULL, (toliman_measure **)&a->made);
}
static toliman_status load_file(attempt *a) {
    const toliman_measure_options options = {
        .struct_size = sizeof options, .kind = TOLIMAN_MEASURE_SEPARATION, .exposure_s = 60};
    return toliman_measure_load_file(in_folder(kText), &options, (toliman_measure **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_measure_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status set_trend(attempt *a) {
    return toliman_measure_set_trend(a->object, 2, 0, 0);
}
static toliman_status query_instruments(attempt *a) {
    size_t count = 0;
    return toliman_measure_query_instruments(a->object, (void *)a->out, 4, &count);
}
static toliman_status set_instruments(attempt *a) {
    int64_t of_samples[SAMPLES];
    for (int i = 0; i < SAMPLES; i++)
        of_samples[i] = i % 2;
    return toliman_measure_set_instruments(a->object, "A B", of_samples, SAMPLES);
}
static toliman_status add_column(attempt *a) {
    return toliman_measure_add_column(a->object, "d", t, SAMPLES, 0);
}
static toliman_status set_prior(attempt *a) {
    return toliman_measure_set_prior(a->object, 0, 3);
}
static toliman_status get_info(attempt *a) {
    return toliman_measure_get_info(a->object, (void *)a->out);
}
static toliman_status get_function(attempt *a) {
    return toliman_measure_get_function(a->object, 0, (void *)a->out);
}
static toliman_status get_values(attempt *a) {
    return toliman_measure_get_values(a->object, "c", (double *)a->out, SAMPLES);
}
static toliman_status get_times(attempt *a) {
    return toliman_measure_get_times(a->object, (int64_t *)a->out, SAMPLES);
}

#define ON_ONE(name, size)                                                                                             \
    { .function = "toliman_measure_" #name, .call = name, .make = make, .of = &measures, .struct_size = size }

static const scenario all[] = {
    {.function = "toliman_measure_create", .call = create, .made = &measures},
    {.function = "toliman_measure_load", .call = load, .made = &measures},
    {.function = "toliman_measure_load_file", .call = load_file, .made = &measures, .stage = put_text},
    ON_ONE(destroy, 0),
    ON_ONE(set_trend, 0),
    ON_ONE(set_instruments, 0),
    ON_ONE(query_instruments, sizeof(toliman_measure_instrument)),
    ON_ONE(add_column, 0),
    ON_ONE(set_prior, 0),
    ON_ONE(get_info, sizeof(toliman_measure_info)),
    ON_ONE(get_function, sizeof(toliman_measure_function)),
    ON_ONE(get_values, 0),
    ON_ONE(get_times, 0),
};
SCENARIO_LIST(measure_scenarios, all);
