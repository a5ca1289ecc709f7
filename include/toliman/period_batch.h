/* libtoliman, periodogram of an archive: the power at every frequency in one call, without a streaming object.
 *
 * Data flow (toliman_period_...)
 *
 *   t, y, sigma -> batch -> power[nf]
 */
#ifndef TOLIMAN_PERIOD_BATCH_H
#define TOLIMAN_PERIOD_BATCH_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag: direct sums only, with an error of 1e-13 whatever the tolerance. */
#define TOLIMAN_PERIOD_DIRECT 512u

/* Options of a batch. */
typedef struct toliman_period_batch_options {
    uint32_t struct_size;
    uint32_t flags;   /* TOLIMAN_PERIOD_FIXED_MEAN, _DIRECT */
    double tolerance; /* largest error of a power, in (0, 0.01]; 0 = 1e-9. Below 1e-13: as TOLIMAN_PERIOD_DIRECT */
    uint32_t threads;
    uint32_t reserved;
    toliman_progress_fn progress;
    void *progress_data;
    /* Nuisance functions (period_nuisance.h) */
    int32_t trend;                 /* in [0, 8] */
    int32_t columns;               /* in [0, 32], together with trend at most 32 */
    double trend_start, trend_end; /* both 0: first and last time */
    double prior_precision[33];    /* in [1e-200, 1e200], that of the mean about 0; 0 = no prior */
    const double *rows;            /* [n][columns] */
} toliman_period_batch_options;
#define TOLIMAN_PERIOD_BATCH_OPTIONS_INIT TOLIMAN_INIT(toliman_period_batch_options)

/* Computes the power of n samples at frequencies f0 + k df, k < nf, to power[nf]; model, weights and grid as in
 * period.h, special cases as toliman_period_query_power. sigma may be NULL, n may be 0.
 *
 * Accuracy  The error of every power of a batch is at most the tolerance, or 1e-13 if that is larger
 *           (promise: batches-meet-their-tolerance). With nuisance functions, the error of period_nuisance.h applies
 *           where it is larger.
 * Memory    A batch takes 35 bytes per sample and 170 bytes per frequency (promise: batch-memory-is-stated). In
 *           addition, each of the second to sixth threads takes 20 bytes per frequency, exact sums 225 bytes per
 *           frequency, and each nuisance function 16 bytes per sample and 50 per frequency.
 * Bits      The same on CPUs of the same kind.
 * Errors    TOLIMAN_E_RANGE for |t| > 1e100, |y| > 1e300, phases above 2^50 cycles, too many samples, times outside the
 *           trend, and, where exact sums are needed, sigmas that differ by a factor above 1e8. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_batch(double f0, double df, int64_t nf, const double *t,
                                                                   const double *y, const double *sigma, size_t n,
                                                                   const toliman_period_batch_options *options,
                                                                   double *power) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
