/* libtoliman, periodogram of an archive: the power at every frequency at once, without a state.
 *
 * Data flow (functions toliman_period_...)
 *
 *   t, y, sigma -> batch -> power[nf]
 *    (batch_options_init)
 */
#ifndef TOLIMAN_PERIOD_BATCH_H
#define TOLIMAN_PERIOD_BATCH_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag: direct sums only, good to 1e-13 whatever the tolerance. */
#define TOLIMAN_PERIOD_DIRECT 512u

/* How toliman_period_batch works. 0 is the default of every member. Since 0.1. */
typedef struct toliman_period_batch_options {
    uint32_t struct_size;
    uint32_t flags;   /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DIRECT */
    double tolerance; /* of every power, up to 0.01; 0 = 1e-9. Below 1e-13: as TOLIMAN_PERIOD_DIRECT */
    uint32_t threads; /* own workers; 0 = one a processor. Never changes a bit of any result */
    uint32_t reserved;
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_period_batch_options;
#define TOLIMAN_PERIOD_BATCH_OPTIONS_INIT TOLIMAN_INIT(toliman_period_batch_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_period_batch_options_init(toliman_period_batch_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Power of an archive of n samples at f0 + k df, k < nf, into power[nf], with the model, weights and grid of a
 * streaming periodogram, but without a state. sigma and options may be NULL; n may be 0. Every power is within the
 * tolerance of the exact one: a non-uniform FFT gives sums of known error, and powers that are not good enough are
 * computed again by compensated direct sums, or where these cancel by exact ones; small archives are summed directly.
 * Special cases are as of query_power, but cosine and sine coincide where the smaller eigenvalue is below 1e-17 of
 * both. Memory while it runs: 35 bytes per sample and 170 per frequency, 20 more on each further thread up to six; 225
 * more per frequency if exact sums are needed. Same input, same bits on one kind of processor: FFTW's last bits differ
 * between kinds. TOLIMAN_E_ARGUMENT for what is not finite, sigma <= 0 and impossible grids; TOLIMAN_E_RANGE for
 * another tolerance, |t| above 1e100, |y| above 1e300, phases of more than 2^50 cycles, n beyond all memory, and where
 * exact sums are needed but sigmas differ by more than 1e8; TOLIMAN_E_MEMORY; TOLIMAN_E_CANCELLED. power is written as
 * a whole or not at all. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_batch(double f0, double df, int64_t nf, const double *t,
                                                                   const double *y, const double *sigma, size_t n,
                                                                   const toliman_period_batch_options *options,
                                                                   double *power) TOLIMAN_NOEXCEPT;
TOLIMAN_END_DECLS

#endif
