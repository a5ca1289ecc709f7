/* libtoliman, false alarm probability (FAP): the probability that noise alone gives a peak of this power or more.
 *
 * Data flow (toliman_period_...)
 *
 *   toliman_period, log10(1 - power) -> query_fap -> log10 FAP -> query_threshold -> log10(1 - power) toliman_period,
 *   samples -> query_bootstrap -> log10(1 - power) of the highest peak of each resampling
 *
 * Every method assumes white noise (otherwise: period_noise.h) with the given relative sigmas. N samples with K
 * nuisance functions (period_nuisance.h), the mean among them, have N - K degrees of freedom. */
#ifndef TOLIMAN_PERIOD_FAP_H
#define TOLIMAN_PERIOD_FAP_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Baluev's upper bound (2008, MNRAS 385, 1279) for one query of the whole grid; close to the true FAP. */
#define TOLIMAN_PERIOD_FAP_BALUEV 111
/* Assumes f T independent frequencies. About 3x too small at 0.01. */
#define TOLIMAN_PERIOD_FAP_NAIVE 112
/* One frequency that was known beforehand: (1 - P)^((N - K - 2)/2), K = 1 for the mean alone. */
#define TOLIMAN_PERIOD_FAP_SINGLE 113
/* Queries of a growing series at any times, which may stop at any time, by alpha spending (Lan and DeMets 1983,
 * Biometrika 70, 659). Of noise series that are queried after every sample from the fifth on, at most 1 in 100 ever
 * reaches a SEQUENTIAL FAP of 0.01 (promise: sequential-alarms-are-rare); with BALUEV 1 in 4 does in 1095 samples. Not
 * for a sliding window: samples must not be selected by their values, nor retracted. */
#define TOLIMAN_PERIOD_FAP_SEQUENTIAL 114

/* Writes log10 of the FAP of a power P. A FAP is never NaN or infinite (promise: faps-are-finite).
 *   method          TOLIMAN_PERIOD_FAP_...
 *   log10_residual  log10(1 - P), in [-4900, 0]
 * Errors: TOLIMAN_E_STATE P > 0 with fewer than five samples or constant values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fap(const toliman_period *period, int32_t method,
                                                                       double log10_residual,
                                                                       double *log10_fap) TOLIMAN_NOEXCEPT;

/* Writes the detection threshold of a FAP: peaks with a lower log10_residual are significant. Inverse of
 * toliman_period_query_fap, also in ranges and errors. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_threshold(const toliman_period *period,
                                                                             int32_t method, double log10_fap,
                                                                             double *log10_residual) TOLIMAN_NOEXCEPT;

/* Options of a bootstrap. */
typedef struct toliman_period_bootstrap_options {
    uint32_t struct_size;
    uint32_t threads;
    uint64_t seed;
    toliman_progress_fn progress;
    void *progress_data;
    const double *rows; /* [n][columns]; NULL without */
} toliman_period_bootstrap_options;
#define TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT TOLIMAN_INIT(toliman_period_bootstrap_options)

/* Bootstrap: writes log10(1 - P) of the highest peak of each of `count` resamplings to log10_residuals[count], sorted,
 * strongest peak first. A resampling keeps the times and draws pairs (y, sigma) with replacement; with nuisance
 * functions, of their residuals.
 *   t, y, sigma  [n], the pushed samples (only n is checked); sigma may be NULL
 * FAP of a peak of toliman_period_query_peak (not _query_fit): (k + 1)/(count + 1), if k entries are at or below its
 * log10_residual. Threshold of a FAP alpha: log10_residuals[alpha * count - 1]. Each thread takes the memory of a
 * periodogram.
 * Errors: as toliman_period_query_fit. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_bootstrap(
    const toliman_period *period, const double *t, const double *y, const double *sigma, size_t n,
    const toliman_period_bootstrap_options *options, size_t count, double *log10_residuals) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
