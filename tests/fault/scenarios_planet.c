/* planet.h */
#include <math.h>

#include "assert_close.h"
#include "scenario.h"

enum { SAMPLES = 40, SIGNALS = 5, DRAWS = 100, LIMITS = 3 };

/* A circular orbit of 90 d, a linear trend, a column, and position angles that turn 3 degrees. */
static toliman_status search_of(void **made) {
    static double t[SAMPLES], y[SAMPLES], sigma[SAMPLES], rows[SAMPLES], angles[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = 8 * i + i % 3;
        y[i] = 5 * sin(2 * 3.14159265358979 * t[i] / 90) + 0.01 * (i * 37 % 101);
        sigma[i] = 0.5 + 0.01 * (i % 7);
        rows[i] = cos(0.02 * t[i]);
        angles[i] = 30 + 0.01 * t[i];
    }
    static toliman_measure *series;
    if (series == NULL) {
        const toliman_measure_data data = {
            .struct_size = sizeof data, .n = SAMPLES, .t = t, .y = y, .sigma = sigma, .position_angle_deg = angles};
        assert_ok(toliman_measure_create(&data, &series));
        assert_ok(toliman_measure_set_trend(series, 1, 0, 0));
        assert_ok(toliman_measure_add_column(series, "rows", rows, SAMPLES, 2));
    }
    toliman_planet_options options = TOLIMAN_PLANET_OPTIONS_INIT;
    options.threads = 2;
    options.prior.period_max = 200;
    options.samples = DRAWS;
    return toliman_planet_create(series, &options, (toliman_planet **)made);
}

static void *make(void) {
    void *made = NULL;
    assert_ok(search_of(&made));
    return made;
}

static void end(void *made) {
    toliman_planet_destroy(made);
}

static uint64_t digest(const void *made) {
    toliman_planet_info info = {.struct_size = sizeof info};
    double residuals[SAMPLES], samples[DRAWS][TOLIMAN_PLANET_COLUMNS];
    assert_ok(toliman_planet_get_info(made, &info));
    assert_ok(toliman_planet_get_residuals(made, SAMPLES, residuals));
    uint64_t all = fnv1a(fnv1a(FNV_START, &info, sizeof info), residuals, sizeof residuals);
    for (uint32_t i = 0; i < info.candidates; i++) {
        toliman_planet_candidate planet = {.struct_size = sizeof planet};
        assert_ok(toliman_planet_get_candidate(made, i, &planet));
        assert_ok(toliman_planet_get_samples(made, i, DRAWS, *samples));
        all = fnv1a(fnv1a(all, &planet, sizeof planet), samples, sizeof samples);
    }
    return all;
}

static const object_kind results = {end, digest};

static toliman_status search(attempt *a) {
    return search_of(&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_planet_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status get_info(attempt *a) {
    return toliman_planet_get_info(a->object, (void *)a->out);
}
static toliman_status get_candidate(attempt *a) {
    return toliman_planet_get_candidate(a->object, 0, (void *)a->out);
}
static toliman_status get_samples(attempt *a) {
    return toliman_planet_get_samples(a->object, 0, DRAWS, (double *)a->out);
}
static toliman_status get_signal(attempt *a) {
    static const double t[SIGNALS] = {0, 10, 400, -50, 33.3}, angles[SIGNALS] = {30, 31, 32, 33, 29};
    return toliman_planet_get_signal(a->object, 0, t, angles, SIGNALS, (double *)a->out);
}
static toliman_status get_residuals(attempt *a) {
    return toliman_planet_get_residuals(a->object, SAMPLES, (double *)a->out);
}
static toliman_status get_instruments(attempt *a) {
    size_t count = 0;
    return toliman_planet_get_instruments(a->object, (void *)a->out, 4, &count);
}
static toliman_status get_outliers(attempt *a) {
    return toliman_planet_get_outliers(a->object, 0, (int64_t *)(void *)a->out);
}
static toliman_status get_limits(attempt *a) {
    static const double periods[LIMITS] = {70, 100, 190};
    return toliman_planet_get_limits(a->object, periods, LIMITS, 0.95, (void *)a->out);
}
static toliman_status inject(attempt *a) {
    const toliman_planet_cell cell = {.struct_size = sizeof cell,
                                      .star = -1,
                                      .period_min = 70,
                                      .period_max = 180,
                                      .size_min = 0.3,
                                      .size_max = 2,
                                      .count = 20};
    return toliman_planet_inject(a->object, &cell, (uint32_t *)(void *)a->out);
}

#define ON_ONE(name, size)                                                                                             \
    { .function = "toliman_planet_" #name, .call = name, .make = make, .of = &results, .struct_size = size, .slow = 1 }

static const scenario all[] = {
    {.function = "toliman_planet_create", .call = search, .made = &results, .slow = 1},
    ON_ONE(destroy, 0),
    ON_ONE(get_info, sizeof(toliman_planet_info)),
    ON_ONE(get_candidate, sizeof(toliman_planet_candidate)),
    ON_ONE(get_samples, 0),
    ON_ONE(get_signal, 0),
    ON_ONE(get_residuals, 0),
    ON_ONE(get_outliers, 0),
    ON_ONE(get_instruments, sizeof(toliman_measure_instrument)),
    ON_ONE(get_limits, sizeof(toliman_planet_limit)),
    ON_ONE(inject, 0),
};
SCENARIO_LIST(planet_scenarios, all);
