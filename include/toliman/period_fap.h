/* libtoliman, false alarm probability: the chance that noise alone has a peak's power, and its inverse.
 *
 * Data flow (functions toliman_period_...)
 *
 *   toliman_period, log10(1 - power) -> query_fap -> log10 of the false alarm probability
 *                                    <- query_threshold <-
 *   toliman_period, samples -> query_bootstrap -> log10(1 - power) of the peaks of resamplings
 *                              (bootstrap_options_init)
 *
 * Source       Baluev (2008), MNRAS 385, 1279; VanderPlas (2018), ApJS 236, 16.
 */
#ifndef TOLIMAN_PERIOD_FAP_H
#define TOLIMAN_PERIOD_FAP_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* False alarm probability: the chance that noise alone has a power P or more, at frequencies up to the grid's last.
 * Source: Baluev; VanderPlas (2018), ApJS 236, 16; for many looks see TOLIMAN_PERIOD_FAP_SEQUENTIAL. */
#define TOLIMAN_PERIOD_FAP_BALUEV                                                                                      \
    111 /* somewhere on the grid: an upper bound, nearly reached. For one query; peaks have it */
#define TOLIMAN_PERIOD_FAP_NAIVE                                                                                       \
    112 /* the same, were there just f T independent frequencies. Too small: at 0.01 by 3 */
#define TOLIMAN_PERIOD_FAP_SINGLE 113 /* at one frequency that was known beforehand: (1 - P)^((N - 3)/2) */
/* Somewhere on the grid, at this or any other number of samples from five on: for querying while samples come in, after
 * each or whenever one likes, and for stopping when one likes. Of streams of noise one in 100 or less ever has 0.01,
 * whereas BALUEV has it at some time in one of three within 1095 samples. What is pushed must not depend on the values,
 * and none may be taken back: over a window that slides it does not hold. It is an alpha spending (Lan and DeMets 1983,
 * Biometrika 70, 659): half by sample 150, without end; looks count by how much they differ (Siegmund 1985, Sequential
 * Analysis). At 0.01 it is 20 times BALUEV's at 150 samples, 80 at 50, 300 at 1000. */
#define TOLIMAN_PERIOD_FAP_SEQUENTIAL 114

/* log10 of the false alarm probability of a power P given as log10(1 - P), in [-4900, 0], for the samples pushed. 0 for
 * P = 0, whatever the samples; never NaN or infinite. TOLIMAN_E_ARGUMENT for other methods and powers, TOLIMAN_E_STATE
 * for P > 0 with fewer than five samples or constant values. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fap(const toliman_period *period, int32_t method,
                                                                       double log10_residual,
                                                                       double *log10_fap) TOLIMAN_NOEXCEPT;

/* The level of a false alarm probability, the inverse: log10(1 - P) of the highest power that has it. log10_fap from
 * that of log10(1 - P) = -4900 to 0; errors as above. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_threshold(const toliman_period *period,
                                                                             int32_t method, double log10_fap,
                                                                             double *log10_residual) TOLIMAN_NOEXCEPT;

/* How toliman_period_query_bootstrap works. 0 is the default of every member. Since 0.1. */
typedef struct toliman_period_bootstrap_options {
    uint32_t struct_size;
    uint32_t threads; /* own workers; 0 = one a processor. Never changes a bit of any result */
    uint64_t seed;
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_period_bootstrap_options;
#define TOLIMAN_PERIOD_BOOTSTRAP_OPTIONS_INIT TOLIMAN_INIT(toliman_period_bootstrap_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_period_bootstrap_options_init(toliman_period_bootstrap_options *options,
                                                       size_t size) TOLIMAN_NOEXCEPT;

/* Bootstrap: log10(1 - P) of the highest peak of each of `count` resamplings of the samples pushed (their number is
 * checked; sigma may be NULL), sorted, the strongest first. A resampling keeps the times and draws to each a value with
 * its sigma, with replacement. If k of the entries are at or below the log10_residual of query_peak (not of
 * query_fit: these are of grid points), its FAP is (k + 1)/(count + 1); entry a count - 1 is the level of FAP a.
 * Assumes no distribution of the noise, but takes a push of all samples and a query a time, and the memory of a
 * periodogram a thread. options may be NULL. TOLIMAN_E_CANCELLED by the progress callback, errors else as query_fit.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_bootstrap(
    const toliman_period *period, const double *t, const double *y, const double *sigma, size_t n,
    const toliman_period_bootstrap_options *options, size_t count, double *log10_residuals) TOLIMAN_NOEXCEPT;
TOLIMAN_END_DECLS

#endif
