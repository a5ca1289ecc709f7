/* Samples of a periodogram with all digits of their time. */
#ifndef SAMPLES_H
#define SAMPLES_H

#include <stdlib.h>

#include <toliman/period.h>

static inline toliman_period_sample sample_ns(int64_t t_ns, double y, double sigma) {
    return (toliman_period_sample){sizeof(toliman_period_sample), TOLIMAN_PERIOD_TIME_NS, 0, 0, t_ns, y, sigma};
}

static inline toliman_period_sample sample_pair(double t, double t_low, double y, double sigma) {
    return (toliman_period_sample){sizeof(toliman_period_sample), 0, t, t_low, 0, y, sigma};
}

static inline toliman_status push_ns(toliman_period *period, int64_t t_ns, double y, double sigma) {
    const toliman_period_sample sample = sample_ns(t_ns, y, sigma);
    return toliman_period_push_samples(period, &sample, NULL, 1);
}

/* sigma may be NULL. */
static inline toliman_status retract_many(toliman_period *period, const double *t, const double *y, const double *sigma,
                                          size_t n) {
    toliman_period_sample *const samples = calloc(n, sizeof *samples);
    for (size_t i = 0; i < n; i++)
        samples[i] = sample_pair(t[i], 0, y[i], sigma != NULL ? sigma[i] : 0);
    const toliman_status status = toliman_period_retract_samples(period, samples, NULL, n);
    free(samples);
    return status;
}

static inline toliman_status retract(toliman_period *period, double t, double y, double sigma) {
    return retract_many(period, &t, &y, &sigma, 1);
}

/* The number of samples; -1 after an error. */
static inline int64_t count_of(const toliman_period *period) {
    toliman_period_info info = TOLIMAN_PERIOD_INFO_INIT;
    return toliman_period_get_info(period, &info) == TOLIMAN_OK ? info.count : -1;
}

#endif
