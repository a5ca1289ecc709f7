/* libtoliman, periodogram: whether the grid suits the times of the samples, and the aliases of a peak.
 *
 * Data flow (toliman_period_...)
 *
 *   toliman_period, times -> query_sampling -> time span, Nyquist frequency, flags
 *   toliman_period, frequency of a peak -> query_aliases -> aliases
 */
#ifndef TOLIMAN_PERIOD_SAMPLING_H
#define TOLIMAN_PERIOD_SAMPLING_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag: single-limb accumulators may give a power with an error above 1e-9 at some frequency above 0: use
 * TOLIMAN_PERIOD_DOUBLE_LIMB. */
#define TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB 128u

/* Sampling diagnostics. */
typedef struct toliman_period_sampling {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_PERIOD_COARSE, _ABOVE_NYQUIST, _NEEDS_DOUBLE_LIMB, _INACCURATE */
    double baseline;    /* T */
    double coarsest_df; /* 1/(5 T); +infinity if all times are equal */
    double nyquist;     /* last frequency of toliman_period_suggest without its limits of size: 1/(2 step) for
                           regular samples; +infinity if all times are equal */
    double independent; /* independent frequencies: last frequency times T, at least 1 */
} toliman_period_sampling;
#define TOLIMAN_PERIOD_SAMPLING_INIT TOLIMAN_INIT(toliman_period_sampling)

/* Writes the sampling diagnostics. Takes the time of toliman_period_query_power.
 *   t  [n], the pushed times (only n is checked). NULL: times are taken as regular; nyquist is then too low if samples
 *      are in groups */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_sampling(
    const toliman_period *period, const double *t, size_t n, toliman_period_sampling *out) TOLIMAN_NOEXCEPT;

/* Intervals that cause aliases. A fraction of a day has the constant of the day (toliman_period_alias.parts). */
#define TOLIMAN_PERIOD_INTERVAL_SAMPLING 121     /* longest at which the samples repeat phases */
#define TOLIMAN_PERIOD_INTERVAL_SOLAR_DAY 122    /* 1 d */
#define TOLIMAN_PERIOD_INTERVAL_SIDEREAL_DAY 123 /* 0.99726957 d */
#define TOLIMAN_PERIOD_INTERVAL_YEAR 124         /* 365.25 d */

/* Alias of a peak of frequency f: samples with an interval 1/g repeat its power at |f - g| and f + g. */
typedef struct toliman_period_alias {
    uint32_t struct_size;
    int32_t interval_kind; /* TOLIMAN_PERIOD_INTERVAL_... */
    double frequency;
    double period;
    double interval; /* 1/g, in units of t */
    double window;   /* fraction of the power that the sampling repeats: the window function at g, in [0.1, 1] */
    double power;    /* highest within 1/T of the alias; NaN outside the grid */
    int32_t equal;   /* 1: the samples cannot distinguish the frequencies: likelihood ratio below 1000; outside the
                        grid, window of at least 0.5 */
    int32_t slow;    /* 1: below the grid and 2.5/T: with equal, a trend or slow change may be the signal */
    int32_t parts;   /* interval = day/parts; otherwise 1 */
    int32_t reserved;
} toliman_period_alias;
#define TOLIMAN_PERIOD_ALIAS_INIT TOLIMAN_INIT(toliman_period_alias)

/* Writes at most 16 aliases of a peak at `frequency`, highest window function first. If the highest peak of the grid is
 * an alias of this one, it is among them. Days and years are those of unit_ns. The window function is known up to twice
 * the last frequency of the grid. Errors: as toliman_period_query_peak. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_aliases(const toliman_period *period,
                                                                           double frequency,
                                                                           toliman_period_alias *aliases,
                                                                           size_t capacity,
                                                                           size_t *count) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
