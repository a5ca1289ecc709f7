/* Noise that is correlated in time, with and without a signal, on regular and irregular times, and its search: tested
 * briefly by test_period_noise, in full by bench_noise. */
#ifndef NOISE_TRIALS_H
#define NOISE_TRIALS_H

#include <stdlib.h>

#include "fap_trials.h"
#include "measure_arrays.h"

enum { NOISE_MOST = 1095, NOISE_OCTAVES = 12, NOISE_MOST_FREQUENCIES = 5500 };

/* Times and the frequency grid of a series. */
typedef struct {
    const char *name;
    size_t n;
    double t[NOISE_MOST];
    double f0, df;
    int64_t nf;
} noise_times;

/* steps: frequencies per width of a peak. */
static inline void noise_grid(noise_times *times, double steps) {
    const double span = times->t[times->n - 1] - times->t[0] + 1;
    times->f0 = 1.5 / span;
    times->df = 1 / (steps * span);
    times->nf = (int64_t)((0.5 - times->f0) / times->df * (1 + 1e-9)) + 1;
}

static inline noise_times noise_regular(size_t n, double steps) {
    noise_times times = {.name = "regular", .n = n};
    for (size_t i = 0; i < n; i++)
        times.t[i] = (double)i;
    noise_grid(&times, steps);
    return times;
}

/* Three years of daily samples without 59 days of each year, when the Sun is near, and without 9 % of the others. */
static inline noise_times noise_seasons(double steps) {
    noise_times times = {.name = "seasons"};
    fap_noise lost = fap_seeded(17);
    for (int day = 0; day < NOISE_MOST; day++)
        if (fmod(day + 50, 365.25) >= 59 && fap_uniform(&lost) > 0.09)
            times.t[times.n++] = day;
    noise_grid(&times, steps);
    return times;
}

/* Adds AR(1) noise of variance 1 with correlation rho per unit of time. */
static inline void noise_add_ar1(const noise_times *times, double rho, fap_noise *random, double *y) {
    double x = 0;
    for (size_t i = 0; i < times->n; i++) {
        const double phi = i > 0 ? pow(rho, times->t[i] - times->t[i - 1]) : 0;
        x = phi * x + sqrt(1 - phi * phi) * fap_normal(random);
        y[i] += x;
    }
}

/* 1/f noise: a sum of AR(1) processes with correlation times in octaves, from half a day to the length of a series. */
static inline void noise_add_flicker(const noise_times *times, fap_noise *random, double *y) {
    for (int octave = 0; octave < NOISE_OCTAVES; octave++)
        noise_add_ar1(times, exp(-ldexp(2, -octave)), random, y);
}

static inline void noise_add_signal(const noise_times *times, fap_signal signal, fap_noise *random, double *y) {
    const double phase = signal.phase < 0 ? 6.283185307179586 * fap_uniform(random) : signal.phase;
    for (size_t i = 0; i < times->n; i++)
        y[i] += signal.amplitude * sin(6.283185307179586 * times->t[i] / signal.period_days + phase);
}

/* Results for white noise, and for correlated noise. */
typedef struct {
    toliman_period_noise white, fitted;
} noise_found;

static inline noise_found noise_search(const noise_times *times, const double *y) {
    toliman_period_noise_options options = TOLIMAN_PERIOD_NOISE_OPTIONS_INIT;
    noise_found found = {TOLIMAN_PERIOD_NOISE_INIT, TOLIMAN_PERIOD_NOISE_INIT};
    assert_ok(noise_search_of(times->f0, times->df, times->nf, times->t, y, NULL, times->n, NULL, NULL, 0, &options,
                              NULL, NULL, NULL, &found.fitted));
    /* The power for white noise needs no fit of the noise. */
    toliman_period *period = NULL;
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    assert_ok(toliman_period_create(times->f0, times->df, times->nf, NULL, &period));
    assert_ok(toliman_period_push_many(period, times->t, y, NULL, times->n));
    assert_ok(toliman_period_query_peak(period, &peak));
    found.white.log10_fap = peak.log10_fap;
    found.white.frequency = peak.frequency;
    toliman_period_destroy(period);
    return found;
}

/* What became of a number of series. */
typedef struct {
    int series, alarms_white, alarms, flagged, flagged_alarms, same_peak;
    double rho, white_fap, fap; /* means */
} noise_counts;

/* Series of a kind: rho < 0 is 1/f noise. */
static inline noise_counts noise_count(const noise_times *times, double rho, fap_signal signal, int series,
                                       uint64_t first) {
    static double y[NOISE_MOST];
    noise_counts counts = {.series = series};
    for (int s = 0; s < series; s++) {
        fap_noise random = fap_seeded(first + (uint64_t)s);
        memset(y, 0, sizeof y);
        if (rho < 0)
            noise_add_flicker(times, &random, y);
        else
            noise_add_ar1(times, rho, &random, y);
        noise_add_signal(times, signal, &random, y);
        const noise_found found = noise_search(times, y);
        const int alarm = found.fitted.log10_fap <= -2, flag = found.fitted.log10_p_white < -3;
        counts.alarms_white += found.white.log10_fap <= -2;
        counts.alarms += alarm;
        counts.flagged += flag;
        counts.flagged_alarms += alarm && flag;
        counts.same_peak += fabs(found.white.frequency - found.fitted.frequency) < 5 * times->df;
        counts.rho += found.fitted.rho / series;
        counts.white_fap += found.white.log10_fap / series;
        counts.fap += found.fitted.log10_fap / series;
    }
    return counts;
}

#endif
