/* Noise with nuisance functions, at the mission's times: how often the FAP is below 0.1 and 0.01. Tested briefly by
 * test_fap_nuisance, in full by bench_fap_nuisance. */
#ifndef NUISANCE_TRIALS_H
#define NUISANCE_TRIALS_H

#include <stdlib.h>
#include <string.h>

#include "fap_trials.h"

#include <toliman/period_nuisance.h>

enum { TRIAL_MOST = 836, TRIAL_DAYS = 1095, TRIAL_ORDER = 5 };

typedef struct {
    int n, functions, columns; /* functions: K, the mean, a trend up to TRIAL_ORDER, columns */
    int priors;                /* the last half of the functions has priors of sigma 1 */
    double t[TRIAL_MOST], rows[TRIAL_MOST][8];
    toliman_period *period;
} nuisance_trial;

static inline int trial_has_prior(const nuisance_trial *trial, int f) {
    return trial->priors && f > 0 && f >= (trial->functions + 1) / 2;
}

/* Chebyshev polynomials or columns: a pair of a year, and harmonics of a longer period. */
static inline double trial_function(const nuisance_trial *trial, int i, int f) {
    const int order = trial->functions - trial->columns - 1;
    const double x = 2 * trial->t[i] / TRIAL_DAYS - 1;
    return f > order ? trial->rows[i][f - order - 1] : cos(f * acos(x));
}

/* n of the days outside a gap of 50 days per year. */
static inline void trial_times(nuisance_trial *trial) {
    fap_noise noise = fap_seeded(77);
    int left = 0, taken = 0;
    for (int day = 0; day < TRIAL_DAYS; day++)
        left += day % 365 >= 50;
    for (int day = 0; day < TRIAL_DAYS; day++)
        if (day % 365 >= 50 && fap_uniform(&noise) * left-- < trial->n - taken) {
            const double t = day + 0.5, year = 6.283185307179586 * t / 365.25;
            const double columns[4] = {cos(year), sin(year), cos(0.37 * year), sin(0.37 * year)};
            memcpy(trial->rows[taken], columns, sizeof columns);
            trial->t[taken++] = t;
        }
    assert_int_equal(taken, trial->n);
}

static inline void trial_begin(nuisance_trial *trial, int n, int functions, int priors) {
    trial->n = n;
    trial->functions = functions;
    trial->priors = priors;
    trial->columns = functions - 1 > TRIAL_ORDER ? functions - 1 - TRIAL_ORDER : 0;
    trial_times(trial);
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.value_bound = 64;
    options.trend = functions - 1 - trial->columns;
    options.trend_end = options.trend > 0 ? TRIAL_DAYS : 0;
    options.columns = trial->columns;
    for (int f = 0; f < functions; f++)
        options.prior_precision[f] = trial_has_prior(trial, f) ? 1 : 0;
    trial->period = NULL;
    assert_ok(toliman_period_create(0.3 / TRIAL_DAYS, 0.1 / TRIAL_DAYS, 545, &options, &trial->period)); /* to 0.05 */
}

/* log10 FAP of the highest peak of a series of noise, in which coefficients with priors are drawn from them. */
static inline double trial_fap(nuisance_trial *trial, uint64_t series) {
    fap_noise noise = fap_seeded(series);
    double coefficients[9] = {0};
    for (int f = 0; f < trial->functions; f++)
        if (trial_has_prior(trial, f))
            coefficients[f] = fap_normal(&noise);
    toliman_period *period = NULL;
    assert_ok(toliman_period_copy(trial->period, &period));
    toliman_period_sample samples[TRIAL_MOST];
    double rows[TRIAL_MOST * 8];
    for (int i = 0; i < trial->n; i++) {
        double y = fap_normal(&noise);
        for (int f = 0; f < trial->functions; f++)
            if (coefficients[f] != 0)
                y += coefficients[f] * trial_function(trial, i, f);
        samples[i] = (toliman_period_sample){.struct_size = sizeof samples[i], .t = trial->t[i], .y = y, .sigma = 1};
        for (int c = 0; c < trial->columns; c++)
            rows[i * trial->columns + c] = trial->rows[i][c];
    }
    assert_ok(toliman_period_push_samples(period, samples, rows, (size_t)trial->n));
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_peak(period, &peak));
    toliman_period_destroy(period);
    return peak.log10_fap;
}

/* Fractions of `series` series of noise with a FAP below 0.1 and 0.01. */
static inline void trial_shares(int n, int functions, int priors, int series, double shares[2]) {
    static nuisance_trial trial;
    trial_begin(&trial, n, functions, priors);
    int below[2] = {0};
    for (int i = 0; i < series; i++) {
        const double log10_fap = trial_fap(&trial, (uint64_t)i + 1000000u * (uint64_t)functions);
        below[0] += log10_fap < -1;
        below[1] += log10_fap < -2;
    }
    toliman_period_destroy(trial.period);
    for (int i = 0; i < 2; i++)
        shares[i] = (double)below[i] / series;
}

/* Whether the shares are in [0.08, 0.11] and [0.006, 0.013], up to two standard errors of the trials. */
static inline int trial_is_calibrated(const double shares[2], int series) {
    const double error1 = 2 * sqrt(0.1 / series), error2 = 2 * sqrt(0.01 / series);
    return shares[0] >= 0.08 - error1 && shares[0] <= 0.11 + error1 && shares[1] >= 0.006 - error2 &&
           shares[1] <= 0.013 + error2;
}

#endif
