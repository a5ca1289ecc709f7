/* Series like the chapter's, one sample per day, evaluated with every false alarm probability: tested briefly by
 * test_fap, in full by bench_fap. */
#ifndef FAP_TRIALS_H
#define FAP_TRIALS_H

#include "assert_close.h"

#include <toliman/period.h>
#include <toliman/period_fap.h>

enum { FAP_METHODS = 3, FAP_FROM = 5, FAP_NEVER = 1 << 30 };
static const int32_t fap_methods[FAP_METHODS] = {TOLIMAN_PERIOD_FAP_BALUEV, TOLIMAN_PERIOD_FAP_NAIVE,
                                                 TOLIMAN_PERIOD_FAP_SEQUENTIAL};
static const char *const fap_names[FAP_METHODS] = {"Baluev", "naive", "sequential"};

/* Standard normal numbers, different for each series. */
typedef struct {
    uint64_t state;
} fap_noise;

static inline double fap_uniform(fap_noise *noise) {
    uint64_t z = noise->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return ((double)((z ^ z >> 31) >> 11) + 0.5) * 0x1p-53;
}

static inline double fap_normal(fap_noise *noise) {
    const double radius = sqrt(-2 * log(fap_uniform(noise)));
    return radius * cos(6.283185307179586 * fap_uniform(noise));
}

static inline fap_noise fap_seeded(uint64_t series) {
    return (fap_noise){series * 0xd1342543de82ef95u + 0x2545f4914f6cdd1du};
}

/* The program's default grid for this number of days: 1.5/T to 1/2, step 1/(10 T). */
static inline toliman_period *fap_periodogram(int days) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(1.5 / days, 0.1 / days, 5 * days - 14, NULL, &period));
    return period;
}

/* log10 FAP of the highest peak by each method. */
static inline void fap_of_peak(const toliman_period *period, double log10_fap[FAP_METHODS]) {
    toliman_period_peak peak = {.struct_size = sizeof peak};
    assert_ok(toliman_period_query_peak(period, &peak));
    for (int m = 0; m < FAP_METHODS; m++)
        assert_ok(toliman_period_query_fap(period, fap_methods[m], peak.log10_residual, &log10_fap[m]));
}

/* A complete series of noise, followed by one query. */
static inline void fap_at_end(const toliman_period *empty, int days, uint64_t series, double log10_fap[FAP_METHODS]) {
    fap_noise noise = fap_seeded(series);
    toliman_period *period = NULL;
    assert_ok(toliman_period_copy(empty, &period));
    for (int day = 0; day < days; day++)
        assert_ok(toliman_period_push(period, day, fap_normal(&noise), 1));
    fap_of_peak(period, log10_fap);
    toliman_period_destroy(period);
}

/* Signal of a series, in units of the noise; phase < 0: random phase. */
typedef struct {
    double amplitude, period_days, phase;
} fap_signal;

/* Queries after every sample: first[m] is the number of samples until method m reaches a FAP of `target`, or
 * FAP_NEVER. */
static inline void fap_watch(const toliman_period *empty, int days, uint64_t series, fap_signal signal, double target,
                             int first[FAP_METHODS]) {
    fap_noise noise = fap_seeded(series);
    const double phase = signal.phase < 0 ? 6.283185307179586 * fap_uniform(&noise) : signal.phase;
    for (int m = 0; m < FAP_METHODS; m++)
        first[m] = FAP_NEVER;
    toliman_period *period = NULL;
    assert_ok(toliman_period_copy(empty, &period));
    for (int day = 0; day < days; day++) {
        const double y = signal.amplitude * sin(6.283185307179586 * day / signal.period_days + phase);
        assert_ok(toliman_period_push(period, day, y + fap_normal(&noise), 1));
        if (day + 1 < FAP_FROM)
            continue;
        double log10_fap[FAP_METHODS];
        fap_of_peak(period, log10_fap);
        for (int m = 0; m < FAP_METHODS; m++)
            if (first[m] == FAP_NEVER && log10_fap[m] <= log10(target))
                first[m] = day + 1;
    }
    toliman_period_destroy(period);
}

static inline int fap_ascending(const void *a, const void *b) {
    return *(const int *)a - *(const int *)b;
}

static inline int fap_median(int *values, size_t count) {
    qsort(values, count, sizeof *values, fap_ascending);
    return values[count / 2];
}

#endif
