/* libtoliman, false alarm probability (FAP): the probability that noise alone gives a peak of this power or more.
 *
 * Every method assumes white noise: independent errors with the given relative sigmas. For correlated noise see
 * period_noise.h. N samples with K nuisance functions (period_nuisance.h), the mean among them, have N - K degrees of
 * freedom.
 *
 * Data flow (functions toliman_period_...)
 *
 *   toliman_period, log10(1 - power) -> query_fap -> log10 FAP
 *   toliman_period, log10 FAP -> query_threshold -> log10(1 - power)
 *   toliman_period, samples -> query_bootstrap -> log10(1 - power) of the highest peak of each resampling
 *
 * Source       Baluev (2008), MNRAS 385, 1279; VanderPlas (2018), ApJS 236, 16.
 */
#ifndef TOLIMAN_PERIOD_FAP_H
#define TOLIMAN_PERIOD_FAP_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* FAP method: Baluev's upper bound for the whole grid, up to its last frequency f; close to the true FAP. Valid for
 * one query. toliman_period_peak.log10_fap is this FAP. */
#define TOLIMAN_PERIOD_FAP_BALUEV 111
/* FAP method: assumes f T independent frequencies. Underestimates the FAP (about 3x too small at 0.01). */
#define TOLIMAN_PERIOD_FAP_NAIVE 112
/* FAP method: FAP at one frequency that was known beforehand: (1 - P)^((N - K - 2)/2), K = 1 for the mean alone. */
#define TOLIMAN_PERIOD_FAP_SINGLE 113
/* FAP method for repeated queries of a growing series. Queries may be made after each sample or at any times, and may
 * stop at any time. Of noise series that are queried after every sample from the fifth on, at most 1 in 100 ever
 * reaches a SEQUENTIAL FAP of 0.01 (promise: sequential-alarms-are-rare). With BALUEV, 1 in 4 does in 1095 samples.
 *
 * Samples must not be selected by their values, and none may be retracted; it does not hold for a sliding window. The
 * method is alpha spending (Lan and DeMets 1983, Biometrika 70, 659): half of the allowed false alarm probability is
 * used for queries up to sample 150, the other half for all later ones. Successive queries are correlated; their
 * effective number is that of Siegmund (1985, Sequential Analysis). A SEQUENTIAL FAP of 0.01 is 80, 20 and 300 times
 * the BALUEV FAP of the same peak at 50, 150 and 1000 samples. */
#define TOLIMAN_PERIOD_FAP_SEQUENTIAL 114

/* Writes log10 of the FAP of a power P to *log10_fap, for the pushed samples. method is TOLIMAN_PERIOD_FAP_...
 *   log10_residual  log10(1 - P), in [-4900, 0]; 0 gives log10 FAP 0 for any samples
 * A FAP is never NaN or infinite (promise: faps-are-finite).
 * Errors: TOLIMAN_E_ARGUMENT for an unknown method or a power out of range; TOLIMAN_E_STATE if P > 0 with fewer than
 * five samples or constant values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fap(const toliman_period *period, int32_t method,
                                                                       double log10_residual,
                                                                       double *log10_fap) TOLIMAN_NOEXCEPT;

/* Writes the detection threshold of a FAP, the inverse of toliman_period_query_fap, to *log10_residual: log10(1 - P)
 * of the power P with this FAP; peaks with a lower log10_residual are significant. log10_fap must be at most 0, and
 * at least the value that toliman_period_query_fap gives for log10_residual = -4900. Errors as
 * toliman_period_query_fap. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_threshold(const toliman_period *period,
                                                                             int32_t method, double log10_fap,
                                                                             double *log10_residual) TOLIMAN_NOEXCEPT;

/* Options of toliman_period_query_bootstrap. */
typedef struct toliman_period_bootstrap_options {
    uint32_t struct_size;
    uint32_t threads;             /* worker threads, 0 = one per processor */
    uint64_t seed;                /* of the random resamplings */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    const double *rows; /* [n][columns] of a periodogram with columns (period_nuisance.h), otherwise NULL */
} toliman_period_bootstrap_options;
#define TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT TOLIMAN_INIT(toliman_period_bootstrap_options)

/* Bootstrap: writes log10(1 - P) of the highest peak of each of `count` resamplings to log10_residuals[count],
 * sorted, strongest peak first. A resampling keeps the times and draws pairs (y, sigma) with replacement.
 *   t, y, sigma  [n], the pushed samples (only n is checked); sigma may be NULL
 *   options      may be NULL
 * If k entries are at or below the log10_residual of toliman_period_query_peak (not of _query_fit), the FAP of that
 * peak is (k + 1)/(count + 1). The detection threshold for a FAP of alpha is log10_residuals[alpha * count - 1]:
 * peaks with a lower log10_residual are significant. The bootstrap assumes no distribution of the noise. Each
 * resampling takes the time to push all samples and query once; each thread needs the memory of a periodogram.
 * With nuisance functions, the values drawn are the residuals of these functions alone.
 * Errors: as toliman_period_query_fit; TOLIMAN_E_CANCELLED. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_bootstrap(
    const toliman_period *period, const double *t, const double *y, const double *sigma, size_t n,
    const toliman_period_bootstrap_options *options, size_t count, double *log10_residuals) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
