/* libtoliman, periodogram: Lomb-Scargle power from exact sums, updated one sample at a time.
 *
 * Data flow (toliman_period_...)
 *
 *   suggest -> f0, df, nf -> create; state bytes -> load, load_file -> toliman_period -> save, save_file
 *   samples -> push, push_many, push_samples, retract_samples; merge, copy, destroy
 *   query_power, query_model, get_info
 *   query_peak, query_peaks, query_fit    period and its error
 *
 * See also: period_fap.h (false alarm probability), period_sampling.h (aliases), period_nuisance.h (trend),
 * period_batch.h (an archive in one call), track.h (frames that may arrive more than once: here every push counts).
 *
 * Model        y = c + a cos(2 pi f t) + b sin(2 pi f t), with weights 1/sigma^2. The mean c is fitted at each
 *              frequency ("floating mean"), or subtracted once (TOLIMAN_PERIOD_FIXED_MEAN).
 * Power        P = 1 - (residual sum of squares of the model)/(that of the mean alone), in [0, 1].
 * Frequencies  f_k = f0 + k df, k = 0 ... nf - 1, not rounded to a double, in cycles per unit of t.
 * Exactness    Any order of pushes gives the same bits on every x86-64 CPU (promise: any-order-gives-same-bits).
 * Accuracy     The power has a known error bound (promise: power-error-is-bounded), at best 2e-15 (design.md, 4).
 *              Double-limb accumulators keep it small for samples that cover less than half a cycle or few of its
 *              phases (toliman_period_query_sampling). Where cosine and sine "coincide", one is fitted.
 *              Powers with a bound above 1e-3 are flagged TOLIMAN_PERIOD_INACCURATE
 *              (promise: inaccurate-powers-are-flagged). Queries return TOLIMAN_E_RANGE if value_bound leaves the
 *              variance of the values fewer than 12 correct digits (promise: lost-digits-are-refused).
 * Time span    T: from the first to the last sample, plus the median step between different times. Without the times, T
 *              = sqrt(12 variance of t).
 * Source       Zechmeister and Kuerster (2009), A&A 496, 577. */
#ifndef TOLIMAN_PERIOD_H
#define TOLIMAN_PERIOD_H

#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Streaming periodogram. */
typedef struct toliman_period toliman_period;

#define TOLIMAN_PERIOD_FIXED_MEAN 1u  /* subtract the weighted mean once */
#define TOLIMAN_PERIOD_DOUBLE_LIMB 2u /* see Accuracy */

/* Options fixed at creation. */
typedef struct toliman_period_options {
    uint32_t struct_size;
    uint32_t flags;      /* TOLIMAN_PERIOD_FIXED_MEAN, _DOUBLE_LIMB */
    double time_offset;  /* subtracted exactly from t */
    double value_offset; /* subtracted exactly from y */
    double value_bound;  /* largest |y - value_offset|, in [1e-100, 1e100]; 0 = 2^20 */
    double sigma_floor;  /* smallest sigma, in [1e-100, 1e100]; 0 = 1 */
    /* Largest sigma, up to 1e8 sigma_floor (else TOLIMAN_E_RANGE); 0 = 32 sigma_floor. Above, the accumulators are
     * double-limb. */
    double sigma_ceiling;
    int64_t time_offset_ns; /* t_ns of t = time_offset */
    double unit_ns;         /* nanoseconds per unit of t, in [1, 1e30]; 0 = 1e9, seconds; 86400e9 = days */
    const toliman_allocator *allocator;
    /* Nuisance functions (period_nuisance.h); double-limb, not with TOLIMAN_PERIOD_FIXED_MEAN. */
    int32_t trend;                 /* order of T_j(x), x from -1 at trend_start to 1 at trend_end, in [0, 8] */
    int32_t columns;               /* values of each sample, in [0, 32], together with trend at most 32 */
    double trend_start, trend_end; /* in units of t; no time may be outside */
    double column_bound[32];       /* largest |value|, in [1e-100, 1e100]; 0 = as 1 */
    /* 1/s_j^2 for the mean (about value_offset), T_1 ... and the columns; s_j in units of y per unit of the function;
     * in [1e-200, 1e200]; 0 = no prior */
    double prior_precision[33];
} toliman_period_options;
#define TOLIMAN_PERIOD_OPTIONS_INIT TOLIMAN_INIT(toliman_period_options)

/* Suggests a frequency grid and options for samples t[n], y[n], sigma[n].
 *   y, sigma      may be NULL
 *   mission_span  0: the samples are complete. > 0: the series will grow to T = mission_span, and the bounds have a
 *                 margin. If n is 0, the step is 1
 *   f0, df, nf    1.5/T, 0.1/T, up to 1/(2 s) if the times differ by multiples of s, otherwise to 5/(2 s), where 5 % of
 *                 the differences are below s; 1024 to 131072 frequencies, at most 2^32/n. May be NULL together
 *   options       receives double-limb accumulators, offsets, bounds; may be NULL
 * Errors: TOLIMAN_E_STATE all times are equal. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_suggest(const double *t, const double *y,
                                                                     const double *sigma, size_t n, double mission_span,
                                                                     double *f0, double *df, int64_t *nf,
                                                                     toliman_period_options *options) TOLIMAN_NOEXCEPT;

/* Creates an empty periodogram on the grid f0 + k df, k < nf: f0 >= 0, df > 0, 1 <= nf <= 2^26, not frequency 0 alone.
 * It takes 129 bytes per frequency (double-limb: 225, and 64 per nuisance function). Pushes and queries allocate
 * nothing (promise: pushes-allocate-nothing), except query_bootstrap, query_fit, query_sampling with times, and the
 * saves. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_create(double f0, double df, int64_t nf,
                                                                    const toliman_period_options *options,
                                                                    toliman_period **out) TOLIMAN_NOEXCEPT;

/* Destroys a periodogram. */
TOLIMAN_API void toliman_period_destroy(toliman_period *period) TOLIMAN_NOEXCEPT;

/* Adds one sample: time t, value y, standard deviation sigma > 0. Samples may share a time.
 * Errors: TOLIMAN_E_RANGE outside the bounds of the options, |t - time_offset| above 1e100 or 2^50 cycles of the
 * highest frequency, more than 2^43 samples; TOLIMAN_E_STATE sigma other than sigma_floor after unweighted samples. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push(toliman_period *period, double t, double y,
                                                                  double sigma) TOLIMAN_NOEXCEPT;

/* Adds n samples, or none if one is refused (promise: pushes-take-all-or-none). sigma NULL: unweighted samples, which
 * count as sigma_floor. Errors: as toliman_period_push; TOLIMAN_E_STATE if unweighted samples would mix with a sigma
 * other than sigma_floor (not detected if all come from a loaded state). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_many(toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       size_t n) TOLIMAN_NOEXCEPT;

#define TOLIMAN_PERIOD_TIME_NS 256u /* the time is t_ns */

/* Sample whose time has more digits than a double: t_ns, or t + t_low, t_low the small one. Members of the other kind
 * are 0. */
typedef struct toliman_period_sample {
    uint32_t struct_size;
    uint32_t flags; /* 0 or TOLIMAN_PERIOD_TIME_NS */
    double t, t_low;
    int64_t t_ns; /* t = time_offset + (t_ns - time_offset_ns)/unit_ns */
    double y;
    double sigma; /* 0 = unweighted */
} toliman_period_sample;
#define TOLIMAN_PERIOD_SAMPLE_INIT TOLIMAN_INIT(toliman_period_sample)

/* Adds n samples, whose kinds of time may differ.
 *   rows  [n][columns], values of the columns; NULL without. With columns, functions without `rows` return
 *         TOLIMAN_E_ARGUMENT
 * Errors: as toliman_period_push_many; TOLIMAN_E_RANGE for a value above its column_bound. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_samples(toliman_period *period,
                                                                          const toliman_period_sample *samples,
                                                                          const double *rows,
                                                                          size_t n) TOLIMAN_NOEXCEPT;

/* Removes n samples pushed with exactly these values and rows, or none if one is refused. A retraction, in any order,
 * leaves the bits of never having pushed these samples (promise: retractions-are-exact). That they were pushed is not
 * checked; where a wrong retract leaves a power above 1, queries return TOLIMAN_E_STATE
 * (promise: wrong-retracts-find-nothing). In a sliding window, multiply the FAP by the number of queries.
 * Errors: as toliman_period_push_samples; TOLIMAN_E_STATE if no samples can have the remaining count and sums. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_samples(toliman_period *period,
                                                                             const toliman_period_sample *samples,
                                                                             const double *rows,
                                                                             size_t n) TOLIMAN_NOEXCEPT;

/* Adds all samples of `other`, which does not change. With equal digests, merged shards have the bits of one
 * periodogram of all samples (promise: merged-shards-give-same-bits). Otherwise sums are converted to this time_offset
 * and value_offset: the power of shards with other references is as accurate, but not bit-identical
 * (promise: other-references-merge).
 * Errors: TOLIMAN_E_MISMATCH other grid, kind of mean, time_offset_ns or unit_ns; single-limb into double-limb;
 * weighted and unweighted samples; another digest with nuisance functions. TOLIMAN_E_RANGE rms about value_offset, or
 * mean 1/sigma^2, outside the bounds. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_merge(toliman_period *period,
                                                                   const toliman_period *other) TOLIMAN_NOEXCEPT;

/* Copies a periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_copy(const toliman_period *period,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Options in force, and counts. */
typedef struct toliman_period_info {
    uint32_t struct_size;
    uint32_t flags;
    int64_t nf;
    double f0, df;
    double time_offset, value_offset, value_bound, sigma_floor;
    int64_t count;
    uint64_t digest; /* hash of grid and options */
    double sigma_ceiling;
    int64_t time_offset_ns;
    double unit_ns;
    int32_t weighted; /* 1: a sample has a sigma other than sigma_floor */
    int32_t reserved;
    int32_t trend, columns;
    double trend_start, trend_end;
    double column_bound[32];
    double prior_precision[33];
    int32_t functions;      /* in use, with the mean */
    int32_t free_functions; /* of these, without a prior */
} toliman_period_info;
#define TOLIMAN_PERIOD_INFO_INIT TOLIMAN_INIT(toliman_period_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_get_info(const toliman_period *period,
                                                                      toliman_period_info *out) TOLIMAN_NOEXCEPT;

/* Normalisations of the power, as in astropy. R, R0: residual sums of squares of the model and of the mean alone. 1 - P
 * >= 1e-15 in MODEL and LOG. */
#define TOLIMAN_PERIOD_POWER_STANDARD 101 /* P = 1 - R/R0 */
#define TOLIMAN_PERIOD_POWER_MODEL 102    /* R0/R - 1 */
#define TOLIMAN_PERIOD_POWER_LOG 103      /* -ln(R/R0) */
#define TOLIMAN_PERIOD_POWER_PSD 104      /* (R0 - R)/2 with weights 1/sigma^2; in units of y^2 if every sigma is 1 */

/* Flag: the error bound of the power exceeds 1e-3 at its grid point; of toliman_period_sampling: anywhere, except at 0
 * and multiples of 1/(2 step), where cosine and sine of regular samples coincide. */
#define TOLIMAN_PERIOD_INACCURATE 16u

/* Writes the power at frequencies first ... first + count - 1 to power[count]. It is never NaN
 * (promise: power-is-never-nan): 0 with fewer than two distinct values, P = 1 with as many free parameters as samples.
 *   normalisation  TOLIMAN_PERIOD_POWER_...
 * Errors: TOLIMAN_E_RANGE lost digits (see Accuracy); TOLIMAN_E_STATE after a wrong retract. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_power(const toliman_period *period,
                                                                         int32_t normalisation, int64_t first,
                                                                         size_t count, double *power) TOLIMAN_NOEXCEPT;

/* Sinusoid fitted at one frequency: y = offset + amplitude sin(2 pi f (t - time_offset) + phase). */
typedef struct toliman_period_model {
    uint32_t struct_size;
    uint32_t rank; /* 2; 1 if cosine and sine coincide */
    double frequency;
    double power;
    double amplitude;
    double phase; /* rad */
    double offset;
    /* Standard errors, as of a peak; 0 for a fixed offset */
    double amplitude_error, phase_error, offset_error;
    uint32_t flags; /* TOLIMAN_PERIOD_INACCURATE */
    uint32_t reserved;
} toliman_period_model;
#define TOLIMAN_PERIOD_MODEL_INIT TOLIMAN_INIT(toliman_period_model)

/* Fits the sinusoid at grid frequency k.
 * Errors: as toliman_period_query_power; TOLIMAN_E_STATE for fewer than five samples (free_functions + 4), or values
 * that mean and nuisance functions describe. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_model(const toliman_period *period, int64_t k,
                                                                         toliman_period_model *out) TOLIMAN_NOEXCEPT;

/* Flag: at the first or last frequency; outside the grid, the power may be higher. */
#define TOLIMAN_PERIOD_AT_EDGE 4u

/* Flag: may be an alias of a higher peak: closer than 2.5/T, or the window function at the difference or sum of their
 * frequencies explains at least half of its power. */
#define TOLIMAN_PERIOD_ALIAS 8u

/* Flag: df > 1/(5 T): peaks may fall between two grid frequencies. */
#define TOLIMAN_PERIOD_COARSE 32u

/* Flag: the grid exceeds `nyquist` of toliman_period_sampling: powers repeat. */
#define TOLIMAN_PERIOD_ABOVE_NYQUIST 64u

/* Flags: the cause is often not a planet.
 *   LONG    period above T/2
 *   ANNUAL  |frequency - 1/yr| < 1/T, with 1 yr = 365.25 d by unit_ns, for T above half a year */
#define TOLIMAN_PERIOD_LONG 2048u
#define TOLIMAN_PERIOD_ANNUAL 4096u

/* Peak of the periodogram. "fit": NaN except from toliman_period_query_fit. Standard errors are scaled by the residual,
 * and +infinity if not determined. */
typedef struct toliman_period_peak {
    uint32_t struct_size;
    uint32_t flags;   /* TOLIMAN_PERIOD_AT_EDGE, _ALIAS (query_peaks only), _INACCURATE, _COARSE, _ABOVE_NYQUIST
                         (query_fit only), _LONG, _ANNUAL */
    double frequency; /* interpolated */
    double period;
    double power;
    double log10_residual; /* log10(1 - P), at least -4900; meaningful down to -14, from query_fit to -31 */
    double fwhm;           /* at half maximum, may be +infinity */
    double fwhm_period;    /* fwhm/f^2: not a standard error */
    double half_width_period;
    double frequency_error; /* fit */
    double amplitude;       /* fit */
    double amplitude_error; /* fit */
    double phase;           /* fit: as in toliman_period_model */
    double offset;          /* fit */
    double log10_fap;       /* TOLIMAN_PERIOD_FAP_BALUEV */
    double period_error;    /* fit */
    /* fit: goodness.h; NaN without absolute sigmas */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;  /* fit */
    uint32_t outliers; /* fit: samples in use farther than 6 robust sigmas from it */
} toliman_period_peak;
#define TOLIMAN_PERIOD_PEAK_INIT TOLIMAN_INIT(toliman_period_peak)

/* Writes the highest peak of the grid, or a longer period whose alias it is and which is as probable
 * (promise: longest-alias-is-shown). Power and FAP of a peak are never overstated (promise: peaks-are-not-overstated):
 * at df = 0.1/T they are up to 1 % low.
 * Errors: as toliman_period_query_power; TOLIMAN_E_STATE for fewer than five samples or constant values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peak(const toliman_period *period,
                                                                        toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* Writes the peak of toliman_period_query_peak, then the highest other local maxima, up to capacity, 1 to 64; their
 * power and FAP contain the scatter of higher ones. Errors: as toliman_period_query_peak. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peaks(const toliman_period *period,
                                                                         toliman_period_peak *peaks, size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Refines the peak of toliman_period_query_peak by a least-squares fit of sinusoid and nuisance functions to the
 * samples. A fit is never worse than its grid point (promise: fits-beat-the-grid), to which TOLIMAN_PERIOD_INACCURATE
 * refers.
 *   t, y, sigma  [n], the samples pushed (only n and the bounds are checked); sigma may be NULL; t from t_ns as in
 *                toliman_period_sample
 *   rows         [n][columns]; NULL without
 * Errors: as toliman_period_query_peak; TOLIMAN_E_RANGE for samples outside the bounds. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fit(const toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       const double *rows, size_t n,
                                                                       toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* Saves a periodogram as state bytes (formats.md, "TLMP").
 * Errors: TOLIMAN_E_STATE if no samples can have these accumulators (promise: unloadable-states-are-not-saved), as
 * after a wrong retract. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save(const toliman_period *period, void *bytes,
                                                                  size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a periodogram.
 * Damaged states and other versions are TOLIMAN_E_FORMAT (promise: damaged-states-are-refused). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load(const void *bytes, size_t size,
                                                                  const toliman_load_options *options,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Saves a periodogram. Files are replaced atomically: after a failure there is the whole old file or, if its folder
 * cannot be synchronized, the whole new one (promise: files-are-replaced-atomically). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save_file(const toliman_period *period,
                                                                       const char *path) TOLIMAN_NOEXCEPT;

/* Loads a periodogram from a file of exactly the size in its header. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load_file(const char *path,
                                                                       const toliman_load_options *options,
                                                                       toliman_period **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
