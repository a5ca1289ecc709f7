/* Series of arrays, for functions that take a toliman_measure. */
#ifndef TOLIMAN_TESTS_MEASURE_ARRAYS_H
#define TOLIMAN_TESTS_MEASURE_ARRAYS_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "assert_close.h"

#include <toliman/period_noise.h>
#include <toliman/sky_diagnosis.h>

/* Adds the columns of functions[n][k] with priors of these precisions; precision may be NULL. */
static inline toliman_status add_measure_columns(toliman_measure *made, const double *functions,
                                                 const double *precision, size_t n, size_t k) {
    double *const column = malloc((n + 1) * sizeof *column);
    toliman_status status = TOLIMAN_OK;
    for (size_t j = 0; j < k && status == TOLIMAN_OK; j++) {
        char name[40];
        snprintf(name, sizeof name, "c%zu", j);
        for (size_t i = 0; i < n; i++)
            column[i] = functions[i * k + j];
        const double sigma = precision != NULL && precision[j] != 0 ? 1 / sqrt(precision[j]) : 0;
        status = toliman_measure_add_column(made, name, column, n, sigma);
    }
    free(column);
    return status;
}

static inline toliman_measure *measure_of(const double *t, const double *y, const double *sigma, size_t n) {
    toliman_measure *made = NULL;
    const toliman_measure_data data = {.struct_size = sizeof data, .n = n, .t = t, .y = y, .sigma = sigma};
    assert_ok(toliman_measure_create(&data, &made));
    return made;
}

/* Measured separations in arcsec; interval_counts as in toliman_measure_data. */
static inline toliman_status measure_separations(const int64_t *intervals, const size_t *interval_counts,
                                                 const double *separations, const double *sigmas, size_t n,
                                                 toliman_measure **made) {
    const toliman_measure_data data = {.struct_size = sizeof data,
                                       .kind = TOLIMAN_MEASURE_SEPARATION,
                                       .n = n,
                                       .y = separations,
                                       .sigma = sigmas,
                                       .intervals = intervals,
                                       .interval_counts = interval_counts,
                                       .unit = 1};
    return toliman_measure_create(&data, made);
}

/* The functions with a series of arrays; the status of the first call that fails. */
static inline toliman_status noise_search_of(double f0, double df, int64_t nf, const double *t, const double *y,
                                             const double *sigma, size_t n, const double *functions,
                                             const double *precision, size_t k,
                                             const toliman_period_noise_options *options, double *power,
                                             double *coefficients, double *errors, toliman_period_noise *out) {
    toliman_measure *made = NULL;
    const toliman_measure_data data = {.struct_size = sizeof data, .n = n, .t = t, .y = y, .sigma = sigma};
    toliman_status status = toliman_measure_create(&data, &made);
    if (status == TOLIMAN_OK)
        status = add_measure_columns(made, functions, precision, n, k);
    if (status == TOLIMAN_OK)
        status = toliman_measure_query_noise(made, f0, df, nf, options, power, coefficients, errors, out);
    toliman_measure_destroy(made);
    return status;
}

static inline toliman_status refit_of(const toliman_sky *sky, const int64_t *intervals, const size_t *interval_counts,
                                      const double *separations, const double *sigmas, size_t n, double scale_sigma,
                                      toliman_sky_refit_result *result, toliman_sky **out) {
    toliman_measure *made = NULL;
    toliman_status status = measure_separations(intervals, interval_counts, separations, sigmas, n, &made);
    if (status == TOLIMAN_OK)
        status = toliman_sky_refit(sky, made, scale_sigma, result, out);
    toliman_measure_destroy(made);
    return status;
}

static inline toliman_status diagnose_of(const toliman_sky *sky, const int64_t *intervals,
                                         const size_t *interval_counts, const double *separations, const double *sigmas,
                                         size_t n, double scale_sigma, toliman_sky_diagnosis *result,
                                         toliman_sky_hypothesis *hypotheses) {
    toliman_measure *made = NULL;
    toliman_status status = measure_separations(intervals, interval_counts, separations, sigmas, n, &made);
    if (status == TOLIMAN_OK)
        status = toliman_sky_diagnose(sky, made, scale_sigma, result, hypotheses);
    toliman_measure_destroy(made);
    return status;
}

/* reduced [n], arcsec: of the measurements that are left; *left receives their number. */
static inline toliman_status reduce_of(const toliman_sky *sky, const int64_t *intervals, const size_t *interval_counts,
                                       const double *separations, size_t n, double *reduced, size_t *left) {
    toliman_measure *made = NULL, *result = NULL;
    toliman_measure_info info = {.struct_size = sizeof info};
    const toliman_sky_reduce_options options = {.struct_size = sizeof options, .flags = TOLIMAN_SKY_NO_FUNCTIONS};
    toliman_status status = measure_separations(intervals, interval_counts, separations, NULL, n, &made);
    if (status == TOLIMAN_OK)
        status = toliman_sky_reduce(sky, made, &options, &result);
    if (status == TOLIMAN_OK)
        status = toliman_measure_get_info(result, &info);
    if (status == TOLIMAN_OK)
        status = toliman_measure_get_values(result, "y", reduced, (size_t)info.n);
    *left = (size_t)info.n;
    toliman_measure_destroy(made);
    toliman_measure_destroy(result);
    return status;
}

#endif
