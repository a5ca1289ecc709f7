/* libtoliman, periodogram: whether the grid suits the times of the samples.
 *
 * Data flow (functions toliman_period_...)
 *
 *   toliman_period, times -> query_sampling -> time span, Nyquist frequency, flags
 */
#ifndef TOLIMAN_PERIOD_SAMPLING_H
#define TOLIMAN_PERIOD_SAMPLING_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag of toliman_period_sampling: at some frequency above 0, single-limb accumulators may give the power with an
 * error above 1e-9. Use TOLIMAN_PERIOD_DOUBLE_LIMB. */
#define TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB 128u

/* Sampling diagnostics: whether the grid suits the times of the samples. */
typedef struct toliman_period_sampling {
    uint32_t struct_size; /* in: sizeof(toliman_period_sampling) */
    uint32_t flags;       /* TOLIMAN_PERIOD_COARSE, _ABOVE_NYQUIST, _NEEDS_DOUBLE_LIMB, _INACCURATE */
    double baseline;      /* T */
    double coarsest_df;   /* 1/(5 T), the largest df that resolves every peak; +infinity if all times are equal */
    double nyquist;       /* 1/(2 step); +infinity if all times are equal */
    double independent;   /* number of independent frequencies: last frequency of the grid times T, at least 1 */
} toliman_period_sampling;
#define TOLIMAN_PERIOD_SAMPLING_INIT TOLIMAN_INIT(toliman_period_sampling)

/* Writes the sampling diagnostics to *out, whose struct_size must be set. t[n] are the pushed times (only n is
 * checked); the step is their median step. If t is NULL, the times are assumed regular with T from their variance;
 * nyquist is then too low for grouped samples. Evaluates every frequency, as toliman_period_query_power does. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_sampling(
    const toliman_period *period, const double *t, size_t n, toliman_period_sampling *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
