/* libtoliman, periodogram of an archive: the power at every frequency in one call, without a streaming object.
 *
 * Data flow (functions toliman_period_...)
 *
 *   t, y, sigma -> batch -> power[nf]
 */
#ifndef TOLIMAN_PERIOD_BATCH_H
#define TOLIMAN_PERIOD_BATCH_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag of toliman_period_batch_options: use direct sums only, with an error of 1e-13 whatever the tolerance. */
#define TOLIMAN_PERIOD_DIRECT 512u

/* Options of toliman_period_batch. */
typedef struct toliman_period_batch_options {
    uint32_t struct_size;
    uint32_t flags;   /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DIRECT */
    double tolerance; /* largest error of a power, in (0, 0.01]; 0 = 1e-9. Below 1e-13: as TOLIMAN_PERIOD_DIRECT */
    uint32_t threads; /* worker threads, 0 = one per processor */
    uint32_t reserved;
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    /* Nuisance functions, as in period_nuisance.h. */
    int32_t trend;                 /* in [0, 8] */
    int32_t columns;               /* in [0, 32], together with trend at most 32 */
    double trend_start, trend_end; /* both 0: first and last time */
    double prior_precision[33];    /* in [1e-200, 1e200], that of the mean about 0; 0 = no prior */
    const double *rows;            /* [n][columns] */
} toliman_period_batch_options;
#define TOLIMAN_PERIOD_BATCH_OPTIONS_INIT TOLIMAN_INIT(toliman_period_batch_options)

/* Computes the power of n samples at frequencies f0 + k df, k < nf, to power[nf], with the model, weights and grid of
 * period.h. sigma and options may be NULL; n may be 0. On failure power is not written.
 *
 * Accuracy: the error of every power of a batch is at most the tolerance, or 1e-13 if that is larger
 * (promise: batches-meet-their-tolerance). A non-uniform FFT computes the sums with a known error bound. Powers that
 * are not accurate enough are computed again by compensated direct sums, and by exact sums where these cancel. Small
 * archives use direct sums throughout. Special cases are those of toliman_period_query_power, but cosine and sine count
 * as coincident where the smaller eigenvalue is below 1e-17 of the sum of both. With nuisance functions there are no
 * direct sums, and exact sums have the accuracy stated in period_nuisance.h.
 *
 * Memory: a batch takes 35 bytes per sample and 170 bytes per frequency (promise: batch-memory-is-stated); 20 bytes
 * more per frequency for each of the second to sixth threads; per nuisance function 16 bytes per sample and 50 bytes
 * per frequency; 225 bytes more per frequency if exact sums are needed. The same input gives the same bits on CPUs of
 * the same kind; the last bits of FFTW differ between kinds. Errors: TOLIMAN_E_ARGUMENT if a number is not finite,
 * sigma <= 0, or the grid is impossible; TOLIMAN_E_RANGE for a tolerance outside [0, 0.01], |t| > 1e100, |y| > 1e300,
 * phases of more than 2^50 cycles, more samples than the address space holds, times outside the span of the trend, or
 * if exact sums are needed and the sigmas differ by a factor of more than 1e8; TOLIMAN_E_CANCELLED. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_batch(double f0, double df, int64_t nf, const double *t,
                                                                   const double *y, const double *sigma, size_t n,
                                                                   const toliman_period_batch_options *options,
                                                                   double *power) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
