/* libtoliman, periodogram: Lomb-Scargle power from exact sums, updated one sample at a time.
 *
 * Data flow (functions toliman_period_...)
 *
 *   suggest -> f0, df, nf -> create      state bytes -> load, load_file
 *                               |                        |
 *                               +------------------------+
 *                               v
 *                        toliman_period  <- push, push_many, push_samples           <- t, y, sigma
 *                               |        <- retract_samples                        <- samples to remove
 *                               |        <- merge                                   <- periodogram of other samples
 *                               +-> query_power                                power[nf]
 *                               +-> query_peak, query_peaks, query_fit         period and its error
 *                               +-> period_fap.h                               false alarm probability
 *                               +-> query_model                                fitted sinusoid
 *                               +-> period_sampling.h                          diagnostics of the sampling
 *                               +-> get_info                                   properties
 *                               +-> save, save_file                            state bytes
 *                          copy, destroy
 *
 * period_nuisance.h: a trend and other known functions, fitted with the mean. period_batch.h: the power of a complete
 * archive without a streaming object. Every pushed sample counts as evidence, also a repeated one. For frames that may
 * arrive more than once, use track.h, which counts each frame once.
 *
 * Model        y = c + a cos(2 pi f t) + b sin(2 pi f t). The mean c is fitted at each frequency ("floating mean");
 *              with TOLIMAN_PERIOD_FIXED_MEAN it is subtracted once.
 * Weights      1/sigma^2.
 * Power        1 - (residual sum of squares of the model)/(that of the mean alone), in [0, 1]; astropy's "standard".
 * Frequencies  f_k = f0 + k df for k = 0 ... nf - 1, not rounded to a double, in cycles per unit of t.
 *              toliman_period_suggest chooses a grid that resolves every peak.
 * Exactness    The sums are fixed-point integers: any order of pushes gives the same bits on every x86-64 CPU
 *              (promise: any-order-gives-same-bits). Single-limb accumulators, the default, resolve weights to 2^-50
 *              and weighted values to 2^-100 of their bounds. Double-limb accumulators resolve 50 bits more, 2^-100 and
 *              2^-150.
 * Accuracy     The power has a known error bound (promise: power-error-is-bounded):
 *                2e-15 + 4e-15 (1 + m) N/(W l)                   single-limb
 *                1e-13 + 6e-16/sqrt(l) + 1e-28 (1 + m) N/(W l)   double-limb, TOLIMAN_PERIOD_DOUBLE_LIMB
 *              with N samples, W = sum (sigma_floor/sigma)^2, m = |mean - value_offset| in weighted standard
 *              deviations of the values, and l the smaller eigenvalue of the covariance matrix of cos 2 pi f t and
 *              sin 2 pi f t. For well-sampled data l is near its maximum 1/2, the power has 14 digits, and
 *              single-limb accumulators suffice. Double-limb accumulators are for frequencies where l is small. There
 *              are two cases: the samples cover less than half a cycle (l is about (f T)^4); or all samples fall on
 *              few phases of the cycle, as regular samples and short nights do near an alias.
 *              toliman_period_query_sampling reports both. If l is very small, cosine and sine are linearly dependent
 *              at the sample times (in this header: "they coincide"), and only one of them is fitted. The limits are
 *                l < 1e-17 of the sum of both eigenvalues, or l < 5e-16 N/W + 4e-16   single-limb
 *                l < 1e-25 of the sum of both eigenvalues, or l < 2e-30 N/W + 4e-31   double-limb
 *              Results whose error bound exceeds 1e-3 have the flag TOLIMAN_PERIOD_INACCURATE
 *              (promise: inaccurate-powers-are-flagged). Queries return TOLIMAN_E_RANGE if the variance of the values
 *              has fewer than 12 correct digits (promise: lost-digits-are-refused), because they scatter too little.
 * Time span    T is the time from the first to the last sample plus one step, the median step between different
 *              times. Functions that do not receive the times use T = sqrt(12 variance of t), which is nearly equal
 *              for regular samples.
 * Source       Zechmeister and Kuerster (2009), A&A 496, 577; Baluev (2008), MNRAS 385, 1279.
 */
#ifndef TOLIMAN_PERIOD_H
#define TOLIMAN_PERIOD_H

#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Streaming periodogram. */
typedef struct toliman_period toliman_period;

/* Flags of toliman_period_options. */
#define TOLIMAN_PERIOD_FIXED_MEAN 1u  /* subtract the weighted mean once, instead of fitting it at each frequency */
#define TOLIMAN_PERIOD_DOUBLE_LIMB 2u /* double-limb accumulators, see Exactness above */

/* Options fixed at creation, because the bits of the accumulators depend on them. */
typedef struct toliman_period_options {
    uint32_t struct_size;
    uint32_t flags;      /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB */
    double time_offset;  /* subtracted exactly from every t; give the first time if time stamps have many digits */
    double value_offset; /* subtracted exactly from every y; give a typical value if the mean is large */
    double
        value_bound; /* largest |y - value_offset| accepted, in [1e-100, 1e100]; 0 = 2^20. Terms are rounded to 2^-100 of it
                            (double-limb: 2^-150). If every sigma is sigma_floor, values may scatter as little as
                            2.6e-17 of it (standard deviation) */
    double sigma_floor; /* smallest sigma accepted, in [1e-100, 1e100]; 0 = 1 */
    /* Largest sigma accepted, up to 1e8 sigma_floor (else TOLIMAN_E_RANGE); 0 = 32 sigma_floor. Up to 32
     * sigma_floor the accumulators are single-limb, with weights (sigma_floor/sigma)^2 rounded to 2^-50. Above, or
     * with TOLIMAN_PERIOD_DOUBLE_LIMB, they are double-limb: a push takes 3 times as long, a query 1.5 times. */
    double sigma_ceiling;
    int64_t time_offset_ns; /* for times in whole nanoseconds: subtracted exactly from t_ns. The instant t_ns =
                               time_offset_ns is the instant t = time_offset */
    double unit_ns;         /* nanoseconds per unit of t, in [1, 1e30]; 0 = 1e9, seconds; 86400e9 = days */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    /* Nuisance functions (period_nuisance.h). Any of them makes the accumulators double-limb and excludes
     * TOLIMAN_PERIOD_FIXED_MEAN. */
    int32_t trend;   /* highest order of T_j(x), x from -1 at trend_start to 1 at trend_end, in [0, 8] */
    int32_t columns; /* number of values that come with each sample, in [0, 32], together with trend at most 32 */
    double trend_start, trend_end; /* in units of t; a time outside is TOLIMAN_E_RANGE */
    double
        column_bound[32]; /* largest |value| of each column, in [1e-100, 1e100], otherwise TOLIMAN_E_RANGE; 0 = as 1 */
    double prior_precision
        [33]; /* 1/s_j^2 for the mean (about value_offset), T_1 ... and the columns, with s_j in units of y per unit of the function, in [1e-200, 1e200]; 0 = no prior */
} toliman_period_options;
#define TOLIMAN_PERIOD_OPTIONS_INIT TOLIMAN_INIT(toliman_period_options)

/* Suggests a frequency grid and options for samples t[n], y[n], sigma[n]. y, sigma and options may be NULL;
 * options->struct_size must be set.
 *
 * The grid is f0 = 1.5/T and df = 0.1/T, with the time span T. The differences of the times give its last frequency:
 * 1/(2 s) if they are multiples of a step s, otherwise 5/(2 s), where 5 % of them are below s. It has at most 131072
 * frequencies, and at most 2^32/n, but at least 1024: 30 MB, and 4.3e9 terms of sums, about 40 s on one processor.
 * *options receives double-limb accumulators, offsets and bounds. f0, df and nf may be NULL together; then one time
 * suffices.
 *   mission_span  0: the samples are complete. > 0, in units of t: the samples grow until T = mission_span. The
 *                 bounds then accept values that spread 2^20 times as far and sigmas 8 times smaller to 4 times
 *                 larger. With n = 0 the step is 1
 * Errors: TOLIMAN_E_ARGUMENT if a number is not finite or sigma <= 0; TOLIMAN_E_STATE if all times are equal. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_suggest(const double *t, const double *y,
                                                                     const double *sigma, size_t n, double mission_span,
                                                                     double *f0, double *df, int64_t *nf,
                                                                     toliman_period_options *options) TOLIMAN_NOEXCEPT;

/* Creates an empty periodogram on the grid f0 + k df, k < nf: f0 >= 0, df > 0, 1 <= nf <= 2^26. A grid of frequency 0
 * alone is refused. options may be NULL. The caller destroys *out.
 *
 * Allocates all memory: 129 bytes per frequency (double-limb: 225; with K - 1 nuisance functions 225 + 64 (K - 1)).
 * Pushes and queries allocate nothing (promise: pushes-allocate-nothing), except query_bootstrap, query_sampling with
 * times, query_fit and the saves. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_create(double f0, double df, int64_t nf,
                                                                    const toliman_period_options *options,
                                                                    toliman_period **out) TOLIMAN_NOEXCEPT;

/* Destroys a periodogram. NULL is allowed. */
TOLIMAN_API void toliman_period_destroy(toliman_period *period) TOLIMAN_NOEXCEPT;

/* Adds one sample: time t, value y, standard deviation sigma. Samples may share a time. For unweighted data, pass
 * sigma = 1 (or sigma_floor) throughout.
 *
 * Each sample counts as evidence: pushing a series five times leaves its power unchanged, but may reduce log10 FAP
 * from -4.5 to -32.
 * Errors: TOLIMAN_E_ARGUMENT if a number is not finite or sigma <= 0; TOLIMAN_E_RANGE if y or sigma is outside the
 * bounds of the options, |t - time_offset| exceeds 1e100 or 2^50 cycles of the highest frequency, or 2^43 samples are
 * present; TOLIMAN_E_STATE if unweighted samples are present and sigma is not sigma_floor. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push(toliman_period *period, double t, double y,
                                                                  double sigma) TOLIMAN_NOEXCEPT;

/* Adds n samples, or none if one is refused (promise: pushes-take-all-or-none); the message names its index. sigma may
 * be NULL: the samples are unweighted and count as sigma_floor.
 * Errors: as toliman_period_push; TOLIMAN_E_STATE if unweighted samples mix with samples whose sigma is not
 * sigma_floor. If all saved samples were unweighted, a periodogram loaded from them no longer detects later mixing. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_many(toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       size_t n) TOLIMAN_NOEXCEPT;

/* Flag of toliman_period_sample: the time is t_ns. */
#define TOLIMAN_PERIOD_TIME_NS 256u

/* Sample whose time has more digits than a double. */
typedef struct toliman_period_sample {
    uint32_t struct_size; /* sizeof(toliman_period_sample) */
    uint32_t flags;       /* 0: the time is t + t_low; TOLIMAN_PERIOD_TIME_NS: the time is t_ns */
    double t, t_low;      /* time as the sum of two doubles; t_low is the small one */
    int64_t t_ns;         /* time in nanoseconds: (t_ns - time_offset_ns)/unit_ns units of t */
    double y;
    double sigma; /* 0 = unweighted */
} toliman_period_sample;
#define TOLIMAN_PERIOD_SAMPLE_INIT TOLIMAN_INIT(toliman_period_sample)

/* Adds n samples, whose kinds of time may differ.
 *   rows  [n][columns of the options], values of the columns (period_nuisance.h); may be NULL if there are none.
 *         Functions without this argument return TOLIMAN_E_ARGUMENT if the periodogram has columns
 * Errors: as toliman_period_push_many; TOLIMAN_E_ARGUMENT if the member of the other kind of time is not 0;
 * TOLIMAN_E_RANGE if a value of a column exceeds its bound. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_samples(toliman_period *period,
                                                                          const toliman_period_sample *samples,
                                                                          const double *rows,
                                                                          size_t n) TOLIMAN_NOEXCEPT;

/* Removes n samples previously pushed with exactly these values, or none if one is refused; samples and rows are
 * as in toliman_period_push_samples. A retraction, in any order, leaves the bits of never having pushed these samples
 * (promise: retractions-are-exact). For a sliding window, push the newest sample and retract the oldest. No FAP method
 * accounts for repeated queries of a sliding window: multiply the FAP of one query by their number.
 *
 * The library cannot check that the samples were pushed. Where a wrong retract leaves a power above 1, queries return
 * TOLIMAN_E_STATE (promise: wrong-retracts-find-nothing).
 * Errors: as toliman_period_push_samples; TOLIMAN_E_STATE if the count would drop below zero, or if no set of samples
 * can have the remaining sums of weights, values and times. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_samples(toliman_period *period,
                                                                             const toliman_period_sample *samples,
                                                                             const double *rows,
                                                                             size_t n) TOLIMAN_NOEXCEPT;

/* Adds all samples of `other`, which does not change. With equal digests (same grid and options), merged shards have
 * the bits of one periodogram of all samples (promise: merged-shards-give-same-bits). Otherwise the accumulators of
 * `other` are first re-referenced (phase-rotated) to this time_offset and value_offset. The power of shards with other
 * references is as accurate, but not bit-identical (promise: other-references-merge).
 * Errors:
 *   - TOLIMAN_E_MISMATCH if the grids, the kinds of mean, time_offset_ns or unit_ns differ, if single-limb
 *     accumulators would be added to double-limb ones, if unweighted samples would mix with samples whose sigma is
 *     not sigma_floor, or if the digests differ and one has nuisance functions;
 *   - TOLIMAN_E_RANGE if the rms of the other's values about this value_offset exceeds this value_bound, or the mean
 *     of its 1/sigma^2 is outside these sigma bounds;
 *   - TOLIMAN_E_ARGUMENT if other is period. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_merge(toliman_period *period,
                                                                   const toliman_period *other) TOLIMAN_NOEXCEPT;

/* Creates an independent copy: same grid, options and samples. The caller destroys *out. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_copy(const toliman_period *period,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Properties of a periodogram. Members with names of toliman_period_options hold the options in force. */
typedef struct toliman_period_info {
    uint32_t struct_size; /* in: sizeof(toliman_period_info) */
    uint32_t flags;
    int64_t nf;
    double f0, df;
    double time_offset, value_offset, value_bound, sigma_floor;
    int64_t count;   /* number of samples */
    uint64_t digest; /* hash of grid and options. Accumulators with equal digests can be compared bit by bit */
    double sigma_ceiling;
    int64_t time_offset_ns;
    double unit_ns;
    int32_t weighted; /* 1: a sample has a sigma other than sigma_floor */
    int32_t reserved;
    int32_t trend, columns; /* nuisance functions, see period_nuisance.h */
    double trend_start, trend_end;
    double column_bound[32];
    double prior_precision[33];
    int32_t functions;      /* number of functions in use, with the mean */
    int32_t free_functions; /* number of those without a prior */
} toliman_period_info;
#define TOLIMAN_PERIOD_INFO_INIT TOLIMAN_INIT(toliman_period_info)

/* Writes the properties of a periodogram to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_get_info(const toliman_period *period,
                                                                      toliman_period_info *out) TOLIMAN_NOEXCEPT;

/* Normalisations of the power, named as in astropy. R is the residual sum of squares of the model, R0 that of the
 * mean alone. 1 - P is resolved to 1e-14; MODEL and LOG use at least 1e-15 for it and are therefore finite. */
#define TOLIMAN_PERIOD_POWER_STANDARD 101 /* P = 1 - R/R0, in [0, 1] */
#define TOLIMAN_PERIOD_POWER_MODEL 102    /* R0/R - 1 */
#define TOLIMAN_PERIOD_POWER_LOG 103      /* -ln(R/R0) */
#define TOLIMAN_PERIOD_POWER_PSD 104      /* (R0 - R)/2 with weights 1/sigma^2; in units of y^2 if every sigma is 1 */

/* Flag of a result: the error bound of the power (see Accuracy above), computed from the accumulators, exceeds 1e-3.
 * For a peak or a model, at its grid point. For toliman_period_sampling, at any frequency above 0 except multiples of
 * 1/(2 step), where cosine and sine of regular samples always coincide. With TOLIMAN_PERIOD_DOUBLE_LIMB it is rare. */
#define TOLIMAN_PERIOD_INACCURATE 16u

/* Writes the power at frequencies first ... first + count - 1 to power[count]. normalisation is a
 * TOLIMAN_PERIOD_POWER_... constant. toliman_period_query_sampling sets TOLIMAN_PERIOD_INACCURATE if a power of
 * the grid may be wrong by more than 1e-3.
 *
 * The power is never NaN (promise: power-is-never-nan). It is 0 if there are fewer than two distinct values, and P = 1
 * if the model has as many free parameters as there are samples. If cosine and sine coincide at a frequency, one of
 * them is fitted. Each frequency takes 2 to 4 ns, or about 100 ns if double precision would leave fewer than 13 correct
 * digits. This happens at frequencies where cosine or sine hardly varies over the samples, and at all frequencies if
 * the mean is more than 30,000 standard deviations from value_offset.
 * Errors: TOLIMAN_E_RANGE outside the grid, or if the values scatter too little for value_bound; TOLIMAN_E_STATE if
 * the power would exceed 1, because a sample was retracted that was never pushed. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_power(const toliman_period *period,
                                                                         int32_t normalisation, int64_t first,
                                                                         size_t count, double *power) TOLIMAN_NOEXCEPT;

/* Sinusoid fitted at one frequency: y = offset + amplitude sin(2 pi f (t - time_offset) + phase). */
typedef struct toliman_period_model {
    uint32_t struct_size; /* in: sizeof(toliman_period_model) */
    uint32_t rank;        /* 2; 1 if cosine and sine coincide at every sample and only one is fitted; 0 if none is */
    double frequency;     /* f0 + k df */
    double power;         /* P */
    double amplitude;
    double phase; /* rad */
    double offset;
    double amplitude_error, phase_error, offset_error; /* standard errors, scaled by the residual; +infinity if the
                                                          samples do not determine them; 0 for a fixed offset */
    uint32_t flags;                                    /* TOLIMAN_PERIOD_INACCURATE */
    uint32_t reserved;
} toliman_period_model;
#define TOLIMAN_PERIOD_MODEL_INIT TOLIMAN_INIT(toliman_period_model)

/* Writes the least-squares sinusoid at grid frequency k to *out, from the accumulators.
 * Errors: as toliman_period_query_power; TOLIMAN_E_RANGE if k is outside the grid; TOLIMAN_E_STATE for fewer than
 * five samples (with nuisance functions: free_functions + 4), or values that are constant or described by the nuisance
 * functions alone. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_model(const toliman_period *period, int64_t k,
                                                                         toliman_period_model *out) TOLIMAN_NOEXCEPT;

/* Flag of a peak at the first or last frequency of the grid. Outside the grid the power may be higher. */
#define TOLIMAN_PERIOD_AT_EDGE 4u

/* Flag of a peak that may be an alias of a higher peak: it is closer than 2.5/T to a higher peak, or a higher peak
 * explains at least half of its power. The explained power follows from the window function at the difference and at
 * the sum of the two frequencies, if these are within the grid. */
#define TOLIMAN_PERIOD_ALIAS 8u

/* Flag: df > 1/(5 T), so that peaks may fall between two grid frequencies. A common cause is a grid in another unit
 * than the times. toliman_period_query_peak and _peaks derive T from the variance of the times, _fit from the times. */
#define TOLIMAN_PERIOD_COARSE 32u

/* Flag: the grid exceeds `nyquist` of toliman_period_sampling, where regular samples repeat the power at lower
 * frequencies. toliman_period_query_peak and _peaks never set it, because the accumulators do not contain the step. */
#define TOLIMAN_PERIOD_ABOVE_NYQUIST 64u

/* Flags of a peak that something other than a planet often causes. query_peak and _peaks derive T from the variance of
 * the times, _fit from the times.
 *   LONG    its period exceeds T/2: a trend of the instrument or the error of an orbit may cause it
 *   ANNUAL  |frequency - 1/yr| < 1/T, with 1 yr = 365.25 d in units of unit_ns, for T above half a year: the motion
 *           of the Earth, seasons and observing windows may cause it */
#define TOLIMAN_PERIOD_LONG 2048u
#define TOLIMAN_PERIOD_ANNUAL 4096u

/* Peak of the periodogram. Members marked "fit" are NaN unless toliman_period_query_fit gives them, because the
 * accumulators do not contain the samples. */
typedef struct toliman_period_peak {
    uint32_t struct_size;     /* in: sizeof(toliman_period_peak) */
    uint32_t flags;           /* TOLIMAN_PERIOD_AT_EDGE, _ALIAS (query_peaks only), _INACCURATE, _COARSE,
                                 _ABOVE_NYQUIST (query_fit only), _LONG, _ANNUAL */
    double frequency;         /* frequency of highest power, interpolated between grid points, within the grid */
    double period;            /* 1/frequency */
    double power;             /* P, in [0, 1] */
    double log10_residual;    /* log10(1 - power), at least -4900; meaningful down to -14 from the accumulators, to -31
                                 from query_fit */
    double fwhm;              /* full width at half maximum in frequency; +infinity if a side stays above half */
    double fwhm_period;       /* fwhm/f^2: width of the peak in period. Not a standard error, although the chapter's
                                 formula uses it as one */
    double half_width_period; /* half of fwhm_period: width that the chapter's table prints as error */
    double frequency_error; /* fit: least-squares standard error; +infinity if not determined. All errors are scaled by
                               the residual: only the ratios of the sigmas matter */
    double amplitude;       /* fit: amplitude of the sinusoid */
    double amplitude_error; /* fit: standard error of the amplitude */
    double phase;           /* fit: rad, as in toliman_period_model */
    double offset;          /* fit: mean of the sinusoid */
    double log10_fap;       /* Baluev's upper bound of the false alarm probability on this grid, for one query. For a
                               query after every sample: toliman_period_query_fap with SEQUENTIAL */
    double period_error;    /* fit: standard error of the period, frequency_error/frequency^2 */
    double chi_square, chi_square_sigma, largest_residual; /* fit: goodness.h; NaN without absolute sigmas */
    int32_t goodness;                                      /* fit: TOLIMAN_GOODNESS_... of chi_square */
    uint32_t outliers; /* fit: samples farther than 6 robust sigmas from the fit; they are not left out */
} toliman_period_peak;
#define TOLIMAN_PERIOD_PEAK_INIT TOLIMAN_INIT(toliman_period_peak)

/* Writes the highest peak of the grid, or a longer period whose alias it is and which is as probable, to *out
 * (promise: longest-alias-is-shown): window function above 0.5, likelihood ratio below the ratio of periods;
 * toliman_period_query_aliases. The frequency is refined by a parabola. Power and FAP of a peak are never overstated
 * (promise: peaks-are-not-overstated): those of the grid point, at df = 0.1/T up to 1 % low. Errors: as
 * toliman_period_query_power; TOLIMAN_E_STATE for fewer than five samples or constant values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peak(const toliman_period *period,
                                                                        toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* Writes the peak of toliman_period_query_peak, then the highest other local maxima, refined likewise, to
 * peaks[capacity], and their number to *count. The number is a choice of the caller: capacity is 1 to 64, and lower
 * peaks are omitted. peaks[0].struct_size must be set. Each peak is judged alone: power and FAP of a lower peak contain
 * the scatter of higher ones. Errors as query_peak. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peaks(const toliman_period *period,
                                                                         toliman_period_peak *peaks, size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Refines the peak of query_peak with the samples t[n], y[n], sigma[n], which must be those pushed (only n and the
 * bounds are checked). For samples pushed with t_ns, give t = time_offset + (t_ns - time_offset_ns)/unit_ns. sigma may
 * be NULL. The refinement is a least-squares fit of frequency, amplitude, phase and offset (the offset is
 * fixed with TOLIMAN_PERIOD_FIXED_MEAN), computed with 64-bit significands. 1 - power is computed from the residuals,
 * accurate down to 1e-31. A fit is never worse than its grid point (promise: fits-beat-the-grid). If cosine and sine
 * coincide at every sample (smaller eigenvalue below 1e-17 of the sum of both), as at the Nyquist frequency of regular
 * samples, one of them is fitted. TOLIMAN_PERIOD_INACCURATE refers to the grid point from which the fit starts.
 * Nuisance functions are fitted with the sinusoid; rows[n][columns] are the values of the columns, and may be NULL if
 * there are none. Errors: as toliman_period_query_peak; TOLIMAN_E_ARGUMENT for another n; TOLIMAN_E_RANGE for samples
 * outside the bounds. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fit(const toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       const double *rows, size_t n,
                                                                       toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* Saves a periodogram as state bytes (formats.md, "TLMP"): bytes[capacity], whose number becomes *needed.
 * The same samples give the same bytes in any order. TOLIMAN_E_CAPACITY if capacity is too small. TOLIMAN_E_STATE if no
 * set of samples can have these accumulators, so that the state could not be loaded
 * (promise: unloadable-states-are-not-saved). This happens after retracting a sample
 * that was never pushed, or one that was added by a merge between different offsets (such a merge is not exact). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save(const toliman_period *period, void *bytes,
                                                                  size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Loads a periodogram from exactly `size` state bytes. options may be NULL. The caller destroys *out.
 * A state with a wrong magic number, version, size or checksum, or impossible content, is TOLIMAN_E_FORMAT
 * (promise: damaged-states-are-refused). Before 1.0, a library loads only its own format versions: 3, and 4 with
 * nuisance functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load(const void *bytes, size_t size,
                                                                  const toliman_load_options *options,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Saves a periodogram to a file. Files are replaced atomically: on failure (TOLIMAN_E_WRITE) the old one remains
 * (promise: files-are-replaced-atomically). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save_file(const toliman_period *period,
                                                                       const char *path) TOLIMAN_NOEXCEPT;

/* Loads a periodogram from a file, whose size must be the one in its header. Otherwise as toliman_period_load. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load_file(const char *path,
                                                                       const toliman_load_options *options,
                                                                       toliman_period **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
