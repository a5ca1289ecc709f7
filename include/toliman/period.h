/* libtoliman, periodogram: Lomb-Scargle power from exact sums that take one sample at a time.
 *
 * Data flow (functions toliman_period_...)
 *
 *   suggest -> f0, df, nf -> create      state bytes -> load, load_file
 *            (options_init)     |                        |
 *                               +------------------------+
 *                               v
 *                        toliman_period  <- push, push_many, push_samples           <- t, y, sigma
 *                               |        <- retract, retract_many, retract_samples  <- the same, removed again
 *                               |        <- merge                                   <- toliman_period of other shards
 *                               +-> query_power                                power[nf]
 *                               +-> query_peak, query_peaks, query_fit         the period and its error
 *                               +-> period_fap.h                               its chance
 *                               +-> query_model, query_sampling                what lies behind it
 *                               +-> get_info, count                            facts
 *                               +-> save, save_file                            state bytes
 *                          copy, reset, destroy
 *
 *   The power of an archive at once, without a state: period_batch.h. Every sample that is pushed counts as evidence,
 *   repeated ones too: frames that may arrive twice belong to track.h, which counts each once.
 *
 * Model        y = c + a cos(2 pi f t) + b sin(2 pi f t), c free (floating mean) unless TOLIMAN_PERIOD_FIXED_MEAN.
 * Weights      1/sigma^2.
 * Power        1 - (residual of the model)/(residual of the mean alone): in [0, 1], astropy's "standard".
 * Frequencies  f_k = f0 + k df for k = 0 ... nf - 1, exactly these real numbers, in cycles per unit of t.
 *              toliman_period_suggest gives those that miss no peak.
 * Exactness    the sums are fixed-point integers: any order of pushes gives the same bits, on every x86-64.
 * Accuracy     power within 2e-15 + 4e-15 (1 + m) N/(W l), with TOLIMAN_PERIOD_DOUBLE_LIMB within 1e-13 + 6e-16/sqrt(l)
 * + 1e-28 (1 + m) N/(W l): N samples, W the sum of (sigma_floor/sigma)^2, m the standard deviations by which the mean
 * is away from value_offset, and l, at most 1/2, the smaller eigenvalue of the covariance of cos and sin 2 pi f t. It
 * is near 1/2 for ordinary times and sigmas, so that the power has 14 digits; it is small, (f T)^4 or so, below half a
 * cycle in the time span T, and likewise where f leaves samples of short nights, or even ones near an alias, to a small
 * part of a cycle: query_sampling tells. Cosine and sine count as coincident, and only one of them is fitted, where l
 * is below 1e-25 (narrow sums: 1e-17) of the sum of both eigenvalues or below 2e-30 N/W + 4e-31 (narrow sums: 5e-16 N/W
 * + 4e-16). Where the bound exceeds 1e-3, as it does there, results have the flag TOLIMAN_PERIOD_INACCURATE.
 *              TOLIMAN_E_RANGE for values that scatter too little for value_bound and the sigmas to have 12 digits.
 * Source       Zechmeister and Kuerster (2009), A&A 496, 577; FAP of Baluev (2008), MNRAS 385, 1279.
 */
#ifndef TOLIMAN_PERIOD_H
#define TOLIMAN_PERIOD_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Streaming periodogram. Const calls may run on one object from several threads. Since 0.1. */
typedef struct toliman_period toliman_period;

/* Flags of toliman_period_options. */
#define TOLIMAN_PERIOD_FIXED_MEAN 1u  /* subtract the weighted mean once instead of fitting it at each f */
#define TOLIMAN_PERIOD_DOUBLE_LIMB 2u /* wide sums, 50 bits more for every term */

/* Options fixed at creation, because the bits of the sums depend on them. 0 is the default of every member. Since 0.1.
 */
typedef struct toliman_period_options {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB */
    /* Subtracted from every t, exactly. Give the first time of long time stamps. Times in nanoseconds have
     * their own offset below: t = time_offset and t_ns = time_offset_ns are the same instant. */
    double time_offset;
    double value_offset; /* subtracted from every y, exactly. Give a typical value if the mean is large */
    /* Largest |y - value_offset| to come; 0 = 2^20. Terms are kept to 2^-100 of it: with sigma_floor everywhere
     * enough for a standard deviation of 2.6e-17 of it. Wide sums keep 2^-150. */
    double value_bound;
    double sigma_floor; /* smallest sigma to come; 0 = 1 */
    /* Largest sigma to come; 0 = 32 sigma_floor; at most 1e8 sigma_floor (else TOLIMAN_E_RANGE). Up to
     * 32 sigma_floor the sums are narrow: weights (sigma_floor/sigma)^2 are kept to 2^-50. Above, or if asked for by
     * TOLIMAN_PERIOD_DOUBLE_LIMB, they are wide, 50 bits more for every term: a push takes three times as long, a query
     * half as long again. */
    double sigma_ceiling;
    /* For times given as whole nanoseconds: subtracted from them, exactly, and how many of them a unit of t has, in
     * [1, 1e30]; 0 = 1e9, so that t is in seconds. 86400e9 makes it days. */
    int64_t time_offset_ns;
    double unit_ns;
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
} toliman_period_options;
#define TOLIMAN_PERIOD_OPTIONS_INIT TOLIMAN_INIT(toliman_period_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_period_options_init(toliman_period_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Suggests a grid and options for samples: f0 = 1.5/T, df = 0.1/T, up to 1/(2 s), T the time span with one step, s the
 * median step between different times. y, sigma and options may be NULL; options->struct_size must be set.
 * mission_span = 0: these are all samples. mission_span > 0 (in units of t): more come until T = mission_span, whose
 * values may spread 2^20 times as far and whose sigmas may be 8 times smaller or 4 times larger; with n = 0, s is 1.
 * *options gets wide sums and the offsets and bounds of these samples. TOLIMAN_E_ARGUMENT for numbers that are not
 * finite or sigma <= 0; TOLIMAN_E_STATE for one time only; TOLIMAN_E_RANGE for more than 2e6 frequencies. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_suggest(const double *t, const double *y,
                                                                     const double *sigma, size_t n, double mission_span,
                                                                     double *f0, double *df, int64_t *nf,
                                                                     toliman_period_options *options) TOLIMAN_NOEXCEPT;

/* Periodogram on a grid: f0 >= 0, df > 0, 1 <= nf <= 2^26, not of frequency 0 alone. options may be NULL. All memory is
 * taken here, 129 bytes a frequency (225 with wide sums); pushes and queries take none but query_fit, which copies the
 * samples, and saving, which makes the bytes. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_create(double f0, double df, int64_t nf,
                                                                    const toliman_period_options *options,
                                                                    toliman_period **out) TOLIMAN_NOEXCEPT;

/* Ends a periodogram; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_period_destroy(toliman_period *period) TOLIMAN_NOEXCEPT;

/* Adds a sample. TOLIMAN_E_ARGUMENT if one of them is not finite or sigma <= 0; TOLIMAN_E_RANGE if the value or sigma
 * is beyond what the options promised, f (t - time_offset) exceeds 2^50 cycles, |t - time_offset| exceeds 1e100, or
 * 2^43 samples are in; the sums are then unchanged. Unweighted data: give 1 (or sigma_floor) everywhere. Several
 * samples may have one time. Each counts as evidence: a series pushed five times has the same power, but log10 FAP -32
 * instead of -4.5. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push(toliman_period *period, double t, double y,
                                                                  double sigma) TOLIMAN_NOEXCEPT;

/* Adds n samples; sigma may be NULL: all are unweighted and count as sigma_floor. All or none: a bad sample is named by
 * its index. TOLIMAN_E_STATE for samples without sigma beside samples whose sigma is not sigma_floor, in either order;
 * state bytes tell of the latter only. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_many(toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       size_t n) TOLIMAN_NOEXCEPT;

/* Flag of toliman_period_sample: t_ns is the time. */
#define TOLIMAN_PERIOD_TIME_NS 256u

/* A sample with all digits of its time. Since 0.2. */
typedef struct toliman_period_sample {
    uint32_t struct_size; /* sizeof(toliman_period_sample); an array has that of its first element throughout */
    uint32_t flags;       /* 0: the time is t + t_low. TOLIMAN_PERIOD_TIME_NS: it is t_ns */
    double t, t_low;      /* two doubles, of which the second is small */
    int64_t t_ns;         /* nanoseconds of a clock: (t_ns - time_offset_ns)/unit_ns units of t */
    double y;
    double sigma; /* 0: unweighted */
} toliman_period_sample;
#define TOLIMAN_PERIOD_SAMPLE_INIT TOLIMAN_INIT(toliman_period_sample)

/* Adds n samples; their kinds of time may differ. TOLIMAN_E_ARGUMENT for a time in the member that flags do not choose;
 * other errors as of toliman_period_push_many. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_samples(toliman_period *period,
                                                                          const toliman_period_sample *samples,
                                                                          size_t n) TOLIMAN_NOEXCEPT;

/* Removes samples previously pushed with exactly these values, one or n. The sums become bit-identical to never having
 * pushed them, in any order. A sliding window is a push and a retract; no FAP holds for many looks at one: multiply
 * that of a single look by their number. The library cannot check that a sample was pushed. TOLIMAN_E_STATE for more
 * samples than are in, and where sums of weights, values and times remain that no samples have: nothing is removed
 * then. A wrong retract that leaves possible totals may make the power at some frequency exceed 1: queries then give
 * TOLIMAN_E_STATE. Other errors as of the pushes. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract(toliman_period *period, double t, double y,
                                                                     double sigma) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_many(toliman_period *period, const double *t,
                                                                          const double *y, const double *sigma,
                                                                          size_t n) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_samples(toliman_period *period,
                                                                             const toliman_period_sample *samples,
                                                                             size_t n) TOLIMAN_NOEXCEPT;

/* Adds all samples of another periodogram, which stays as it is. With equal digests (grid and options) the result has
 * the bits that pushing all samples into one would give, in whatever shards and order. With other references of time or
 * value, or other bounds, the other's sums are turned to this one's first: power then as accurate still, but not
 * the same bits. TOLIMAN_E_MISMATCH for other frequencies or kinds of mean, for narrow sums into wide ones, and for
 * another time_offset_ns or unit_ns, which shards must share, and for samples without sigma and others whose sigma is
 * not sigma_floor; TOLIMAN_E_RANGE where the root mean square of the other's values, from this value_offset, is above
 * this value_bound, or the mean of their 1/sigma^2 beyond these sigmas; TOLIMAN_E_ARGUMENT for other = period. Since
 * 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_merge(toliman_period *period,
                                                                   const toliman_period *other) TOLIMAN_NOEXCEPT;

/* A periodogram of its own with the same grid, options and samples. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_copy(const toliman_period *period,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Forgets every sample; grid and options stay. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_reset(toliman_period *period) TOLIMAN_NOEXCEPT;

/* Samples pushed so far; 0 for NULL. Since 0.1. */
TOLIMAN_API int64_t toliman_period_count(const toliman_period *period) TOLIMAN_NOEXCEPT;

/* Facts of a periodogram. Since 0.1. */
typedef struct toliman_period_info {
    uint32_t struct_size; /* in: sizeof(toliman_period_info) */
    uint32_t flags;
    int64_t nf;
    double f0, df;
    double time_offset, value_offset, value_bound, sigma_floor;
    int64_t count;   /* samples */
    uint64_t digest; /* identity of grid and options; equal digests may be compared sum by sum */
    double sigma_ceiling;
    int64_t time_offset_ns;
    double unit_ns;
    int32_t weighted; /* 1: some sample's sigma is not sigma_floor */
    int32_t reserved;
} toliman_period_info;
#define TOLIMAN_PERIOD_INFO_INIT TOLIMAN_INIT(toliman_period_info)

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_get_info(const toliman_period *period,
                                                                      toliman_period_info *out) TOLIMAN_NOEXCEPT;

/* Normalisations of the power, as astropy names them, of the residual sums of squares R of the model and R0 of the
 * mean. 1 - P is resolved to 1e-14 only; MODEL and LOG take it as 1e-15 at least and are never infinite. */
#define TOLIMAN_PERIOD_POWER_STANDARD 101 /* P = 1 - R/R0, in [0, 1] */
#define TOLIMAN_PERIOD_POWER_MODEL 102    /* R0/R - 1 */
#define TOLIMAN_PERIOD_POWER_LOG 103      /* -ln(R/R0) */
#define TOLIMAN_PERIOD_POWER_PSD                                                                                       \
    104 /* (R0 - R)/2 with weights 1/sigma^2: of the units of y^2 where all sigmas are 1                               \
         */

/* Flag: the error bound of the power (Accuracy, above), computed from the sums, exceeds 1e-3. Of a peak or a model: at
 * its grid point. Of toliman_period_sampling: at some frequency above 0 that is no multiple of 1/(2 step) (to 1e-9),
 * where an even series has one phase. TOLIMAN_PERIOD_DOUBLE_LIMB lowers the bound by 1e13. */
#define TOLIMAN_PERIOD_INACCURATE 16u

/* Power at frequencies first ... first + count - 1. toliman_period_query_sampling has TOLIMAN_PERIOD_INACCURATE where
 * some power of the grid may be wrong by more than 1e-3. Never NaN: fewer than two distinct values give 0, as many free
 * parameters as samples give P = 1, a frequency at which cosine and sine coincide is solved in the one that is left.
 * Takes 2 to 4 ns a frequency by vectors, some 100 ns where doubles do not carry 13 digits: where cosine or sine hardly
 * varies, and everywhere if the mean is more than 30,000 standard deviations away from value_offset. TOLIMAN_E_RANGE
 * if the values scatter too little for value_bound. TOLIMAN_E_STATE where the power would exceed 1 beyond rounding: a
 * sample was retracted that was never pushed. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_power(const toliman_period *period,
                                                                         int32_t normalisation, int64_t first,
                                                                         size_t count, double *power) TOLIMAN_NOEXCEPT;

/* The model at one frequency, y = offset + amplitude sin(2 pi f (t - time_offset) + phase). Since 0.1. */
typedef struct toliman_period_model {
    uint32_t struct_size; /* in: sizeof(toliman_period_model) */
    uint32_t rank;        /* 2; 1 where cosine and sine coincide at every sample and only one is fitted; 0 none */
    double frequency;     /* f0 + k df */
    double power;         /* P */
    double amplitude;
    double phase; /* rad */
    double offset;
    double amplitude_error, phase_error, offset_error; /* standard errors, scaled by the residual; +infinity where the
                                                          samples cannot tell, 0 of a fixed offset */
    /* TOLIMAN_PERIOD_INACCURATE */
    uint32_t flags;
    uint32_t reserved;
} toliman_period_model;
#define TOLIMAN_PERIOD_MODEL_INIT TOLIMAN_INIT(toliman_period_model)

/* Least squares at frequency k of the grid, from the sums. TOLIMAN_E_RANGE for k outside the grid and as query_power,
 * TOLIMAN_E_STATE with fewer than five samples or constant values. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_model(const toliman_period *period, int64_t k,
                                                                         toliman_period_model *out) TOLIMAN_NOEXCEPT;

/* Flag of a peak at the grid's first or last frequency: beyond it the power may be greater, and the period another. */
#define TOLIMAN_PERIOD_AT_EDGE 4u
/* Flag of a peak half of whose power or more the sampling could make of a higher one: by the window function at the
 * distance or at the sum of their frequencies, as far as these are on the grid; or within 2.5/T of it, T the time span.
 */
#define TOLIMAN_PERIOD_ALIAS 8u

/* Flags of a peak and of toliman_period_sampling: df > 1/(5 T), so that peaks may lie unseen between two frequencies;
 * the grid goes beyond 1/(2 step), where even samples repeat what is below. Both are usual where the grid is in another
 * unit than the times. query_peak and query_peaks take T from the variance of the times, and never have ABOVE_NYQUIST,
 * as sums do not tell the step; query_fit takes both from the times. */
#define TOLIMAN_PERIOD_COARSE 32u
#define TOLIMAN_PERIOD_ABOVE_NYQUIST 64u

/* A peak and what it means. Since 0.1. */
typedef struct toliman_period_peak {
    uint32_t struct_size;  /* in: sizeof(toliman_period_peak) */
    uint32_t flags;        /* TOLIMAN_PERIOD_AT_EDGE, _ALIAS (of query_peaks only), _INACCURATE, _COARSE,
                            * _ABOVE_NYQUIST (of query_fit only) */
    double frequency;      /* between grid points, where the power is greatest; never outside the grid */
    double period;         /* 1/frequency */
    double power;          /* in [0, 1] */
    double log10_residual; /* log10(1 - power), formed from residual/total; -4900 at least */
    double fwhm; /* full width at half maximum of the peak, in frequency; +infinity if a side never falls so low */
    double fwhm_period;       /* fwhm/f^2: error of the period as the chapter's formula prints it */
    double half_width_period; /* half of it, as the chapter's table prints it */
    double frequency_error;   /* least-squares standard error, +infinity if the samples cannot tell; NaN from
                               * query_peak, which sees no samples. As all errors scaled by the residuals: of the sigmas
                               * only the proportions count */
    double amplitude;         /* of the sinusoid; NaN from query_peak */
    double amplitude_error;   /* the same; NaN from query_peak */
    double phase;             /* rad, y = offset + amplitude sin(2 pi f (t - time_offset) + phase); NaN as above */
    double offset;            /* NaN as above */
    double log10_fap;    /* Baluev's upper bound of the chance that noise alone peaks so high on this grid, at one look.
                          * For a look after every sample: toliman_period_query_fap of log10_residual, SEQUENTIAL */
    double period_error; /* frequency_error/frequency^2: the standard error of the period; NaN as above */
} toliman_period_peak;
#define TOLIMAN_PERIOD_PEAK_INIT TOLIMAN_INIT(toliman_period_peak)

/* Highest peak of the grid: the frequency is refined by a parabola, power and FAP are those of the highest grid point.
 * So they never claim more than the peak has, and up to 1 % less power where df is 0.1/T; 1 - power is resolved to
 * 1e-14 only. TOLIMAN_E_STATE with fewer than five samples or constant values, TOLIMAN_E_RANGE as query_power. Since
 * 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peak(const toliman_period *period,
                                                                        toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* The highest peaks of the grid, local maxima refined likewise, highest first: at most `capacity`, 1 to 64, into
 * peaks[capacity], whose first has its struct_size set; *count is how many there are. Each is judged as if it were the
 * only one: power and FAP of lower ones still hold the higher ones' scatter. Errors as of query_peak. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peaks(const toliman_period *period, size_t capacity,
                                                                         toliman_period_peak *peaks,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* The highest peak refined against the samples themselves, which must be those pushed (their number is checked; sigma
 * may be NULL): least squares in frequency, amplitude, phase and offset with 64-bit mantissas, 1 - power from the
 * residuals and therefore right even when it is 1e-31. Never worse than the highest grid point. Where cosine and sine
 * coincide at every sample, as at the Nyquist frequency of even times, the one that is left is fitted; here they
 * coincide below 1e-17 of the sum of both eigenvalues. TOLIMAN_PERIOD_INACCURATE tells of the grid point from which the
 * fit started. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fit(const toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma, size_t n,
                                                                       toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* Flag of toliman_period_sampling. At some frequency above 0 narrow sums may give the power to less than 1e-9: as where
 * cosine and sine hardly differ, or coincide, which narrow sums cannot tell from each other. */
#define TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB 128u

/* What the samples' times are worth, and whether the grid suits them. Since 0.1. */
typedef struct toliman_period_sampling {
    uint32_t struct_size; /* in: sizeof(toliman_period_sampling) */
    uint32_t flags;       /* TOLIMAN_PERIOD_COARSE, _ABOVE_NYQUIST, _NEEDS_DOUBLE_LIMB, _INACCURATE */
    double baseline;      /* T: time span and one step */
    double coarsest_df;   /* 1/(5 T); +infinity while all times are one */
    double nyquist;       /* 1/(2 step); the same */
    double independent;   /* frequencies of the grid that are independent of each other: its last one times T, or 1 */
} toliman_period_sampling;
#define TOLIMAN_PERIOD_SAMPLING_INIT TOLIMAN_INIT(toliman_period_sampling)

/* Fills *out; out->struct_size must be set. With t, the n times that were pushed (their number is checked), the step is
 * the median one; with t NULL they are taken as evenly spread, T from their variance, which is right for regular
 * samples and makes the ceiling of samples in groups too low. Looks at every frequency, as toliman_period_query_power
 * does. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_sampling(
    const toliman_period *period, const double *t, size_t n, toliman_period_sampling *out) TOLIMAN_NOEXCEPT;

/* State bytes ("TLMP", formats.md). With bytes NULL only *needed is set, at no cost; otherwise capacity must be at
 * least that (TOLIMAN_E_CAPACITY). The same samples give the same bytes, whatever their order. TOLIMAN_E_STATE for sums
 * that no samples have, which could not be loaded again: samples were taken back that never came, or that came by a
 * merge of other references, which is not exact. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save(const toliman_period *period, void *bytes,
                                                                  size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Periodogram from exactly size state bytes. TOLIMAN_E_FORMAT for a wrong magic, version, size or checksum and for
 * impossible content: before 1.0 only this version's bytes load. options may be NULL. Destroy *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load(const void *bytes, size_t size,
                                                                  const toliman_load_options *options,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* The same to and from a file; saving replaces it as a whole or not at all (TOLIMAN_E_WRITE). Loading
 * reads the header first, and no more of a file that has not the size it tells. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save_file(const toliman_period *period,
                                                                       const char *path) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load_file(const char *path,
                                                                       const toliman_load_options *options,
                                                                       toliman_period **out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
