/* Samples of a periodogram with all digits of their time. */
#ifndef SAMPLES_H
#define SAMPLES_H

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

static inline toliman_status retract(toliman_period *period, double t, double y, double sigma) {
    return toliman_period_retract_many(period, &t, &y, &sigma, 1);
}

#endif
