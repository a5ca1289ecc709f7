/* libtoliman, periodogram: Lomb-Scargle power from exact sums that take one sample at a time.
 *
 * Model        y = c + a cos(2 pi f t) + b sin(2 pi f t), c free (floating mean) unless TOLIMAN_PERIOD_FIXED_MEAN.
 * Weights      1/sigma^2.
 * Power        1 - (residual of the model)/(residual of the mean alone): in [0, 1], astropy's "standard".
 * Frequencies  f_k = f0 + k df for k = 0 ... nf - 1, exactly these real numbers, in cycles per unit of t.
 * Exactness    the sums are fixed-point integers: any order of pushes gives the same bits, on every x86-64.
 * Accuracy     power within 1e-12, for sigmas from sigma_floor to sigma_ceiling in any proportion (up to 1 to 1e8);
 *              within 1e-17 (f T)^-4 where f times the time span T is below 0.05; and 3e-17 more for every standard
 *              deviation by which the mean is away from value_offset. Queries refuse values that scatter too little for
 *              value_bound and the sigmas to have these digits (TOLIMAN_E_RANGE).
 * Source       Zechmeister and Kuerster (2009), A&A 496, 577; FAP of Baluev (2008), MNRAS 385, 1279.
 */
#ifndef TOLIMAN_PERIOD_H
#define TOLIMAN_PERIOD_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Streaming periodogram. Const calls may run on one object from several threads. Since 0.1. */
typedef struct toliman_period toliman_period;

#define TOLIMAN_PERIOD_FIXED_MEAN 1u /* flag: subtract the weighted mean once instead of fitting it at each f */

/* What is fixed for the life of a periodogram, because the bits of its sums depend on it. Since 0.1. */
typedef struct toliman_period_options {
    uint32_t struct_size;
    uint32_t flags;      /* TOLIMAN_PERIOD_..., default 0 */
    double time_offset;  /* subtracted from every t, exactly; default 0. Give the first time of long time stamps */
    double value_offset; /* subtracted from every y, exactly; default 0. Give a typical value if the mean is large */
    /* Largest |y - value_offset| to come; default 2^20. Terms are kept to 2^-100 of it: with sigma_floor everywhere
     * enough for a standard deviation of 2.6e-17 of it. Wide sums keep 2^-150. */
    double value_bound;
    double sigma_floor; /* smallest sigma to come; default 1 */
    /* Largest sigma to come; default 0, which is 32 sigma_floor; at most 1e8 sigma_floor (else TOLIMAN_E_RANGE). Up to
     * 32 sigma_floor the sums are narrow: weights (sigma_floor/sigma)^2 are kept to 2^-50. Above they are wide, 50 bits
     * more for every term: a push takes three times as long, a query of the power some fifteen times. */
    double sigma_ceiling;
    /* For times given as whole nanoseconds: subtracted from them, exactly, and how many of them a unit of t has, in
     * [1, 1e30]; defaults 0 and 1e9, so that t is in seconds. 86400e9 makes it days. */
    int64_t time_offset_ns;
    double unit_ns;
} toliman_period_options;

/* Fills *options with the defaults. Since 0.1. */
TOLIMAN_API void toliman_period_options_init(toliman_period_options *options) TOLIMAN_NOEXCEPT;

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
 * 2^43 samples are in; the sums are then unchanged. Unweighted data: give 1 (or sigma_floor) everywhere. Duplicate
 * times are allowed. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push(toliman_period *period, double t, double y,
                                                                  double sigma) TOLIMAN_NOEXCEPT;

/* Adds n samples; sigma may be NULL (unweighted). All or none: a bad sample is named by its index. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_many(toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma,
                                                                       size_t n) TOLIMAN_NOEXCEPT;

/* The same with the time t + t_low, two doubles of which the second is small, or in nanoseconds of the camera's clock,
 * (t_ns - time_offset_ns)/unit_ns units of t: neither loses a digit. All kinds of times may be mixed. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_pair(toliman_period *period, double t, double t_low,
                                                                       double y, double sigma) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_push_ns(toliman_period *period, int64_t t_ns, double y,
                                                                     double sigma) TOLIMAN_NOEXCEPT;

/* Takes back a sample that was pushed, given by the same numbers: the sums are then the bits that they would be without
 * it, whatever was pushed in between. A window that slides is a push and a retract. Whether the sample was ever pushed
 * cannot be seen, only that as many are in (TOLIMAN_E_STATE); other errors as of the pushes. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract(toliman_period *period, double t, double y,
                                                                     double sigma) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_pair(toliman_period *period, double t,
                                                                          double t_low, double y,
                                                                          double sigma) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_ns(toliman_period *period, int64_t t_ns, double y,
                                                                        double sigma) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_retract_many(toliman_period *period, const double *t,
                                                                          const double *y, const double *sigma,
                                                                          size_t n) TOLIMAN_NOEXCEPT;

/* Adds all samples of another periodogram, which stays as it is. With equal digests (grid and options) the result has
 * the bits that pushing all samples into one would give, in whatever shards and order. With other references of time or
 * value, a smaller value_bound or a larger sigma_floor the other's sums are turned to this one's first: power then
 * within 1e-12 still, but not the same bits. TOLIMAN_E_MISMATCH for other frequencies, kinds of mean or references in
 * nanoseconds; TOLIMAN_E_RANGE where what the other's options allow is beyond this one's; TOLIMAN_E_ARGUMENT for other
 * = period. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_merge(toliman_period *period,
                                                                   const toliman_period *other) TOLIMAN_NOEXCEPT;

/* A periodogram of its own with the same grid, options and samples. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_copy(const toliman_period *period,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* Forgets every sample; grid and options stay. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_reset(toliman_period *period) TOLIMAN_NOEXCEPT;

/* Samples pushed so far; 0 for NULL. Since 0.1. */
TOLIMAN_API int64_t toliman_period_count(const toliman_period *period) TOLIMAN_NOEXCEPT;

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
} toliman_period_info;

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_get_info(const toliman_period *period,
                                                                      toliman_period_info *out) TOLIMAN_NOEXCEPT;

/* Power at frequencies first ... first + count - 1. Never NaN: fewer than two distinct values give 0, as many free
 * parameters as samples give 1, a frequency at which cosine and sine coincide is solved in the one that is left.
 * TOLIMAN_E_RANGE if the values scatter too little for value_bound. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_power(const toliman_period *period, int64_t first,
                                                                         size_t count, double *power) TOLIMAN_NOEXCEPT;

/* Flag of a peak at the grid's first or last frequency: beyond it the power may be greater, and the period another. */
#define TOLIMAN_PERIOD_AT_EDGE 1u

/* A peak and what it means. Since 0.1. */
typedef struct toliman_period_peak {
    uint32_t struct_size;  /* in: sizeof(toliman_period_peak) */
    uint32_t flags;        /* TOLIMAN_PERIOD_AT_EDGE or 0 */
    double frequency;      /* between grid points, where the power is greatest; never outside the grid */
    double period;         /* 1/frequency */
    double power;          /* in [0, 1] */
    double log10_residual; /* log10(1 - power), formed from residual/total; -4900 at least */
    double fwhm; /* full width at half maximum of the peak, in frequency; +infinity if a side never falls so low */
    double fwhm_error;       /* fwhm/f^2: error of the period as the chapter's formula prints it */
    double half_width_error; /* half of it, as the chapter's table prints it */
    double frequency_error;  /* least-squares standard error, +infinity if the samples cannot tell; NaN from
                              * query_peak, which sees no samples */
    double amplitude;        /* of the sinusoid; NaN from query_peak */
    double amplitude_error;  /* the same; NaN from query_peak */
    double phase;            /* rad, y = offset + amplitude sin(2 pi f (t - time_offset) + phase); NaN as above */
    double offset;           /* NaN as above */
    double log10_fap;        /* Baluev's upper bound of the chance that noise alone peaks so high on this grid */
} toliman_period_peak;

/* Highest peak of the grid, refined by a parabola. 1 - power is resolved to 1e-14 only. TOLIMAN_E_STATE with fewer than
 * five samples or constant values, TOLIMAN_E_RANGE as query_power. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_peak(const toliman_period *period,
                                                                        toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* The same peak refined against the samples themselves, which must be those pushed (their number is checked; sigma may
 * be NULL): least squares in frequency, amplitude, phase and offset with 64-bit mantissas, 1 - power from the residuals
 * and therefore right even when it is 1e-31. Never worse than the highest grid point. Where cosine and sine coincide at
 * every sample, as at the Nyquist frequency of even times, the one that is left is fitted. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fit(const toliman_period *period, const double *t,
                                                                       const double *y, const double *sigma, size_t n,
                                                                       toliman_period_peak *out) TOLIMAN_NOEXCEPT;

/* log10 of Baluev's false alarm probability of a power P given as log10(1 - P), for the samples pushed and frequencies
 * up to the grid's last. 0 for P = 0; never NaN or infinite: 1 - P is at least 10^-4900. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_fap(const toliman_period *period,
                                                                       double log10_residual,
                                                                       double *log10_fap) TOLIMAN_NOEXCEPT;

/* State bytes ("TLMP", lib/FORMATS.md). With bytes NULL only *needed is set, at no cost; otherwise capacity must be at
 * least that (TOLIMAN_E_CAPACITY). The same samples give the same bytes, whatever their order. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save(const toliman_period *period, void *bytes,
                                                                  size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Periodogram from exactly size state bytes. TOLIMAN_E_FORMAT for a wrong magic, version, size or checksum and for
 * impossible content: before 1.0 only this version's bytes load. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load(const void *bytes, size_t size,
                                                                  toliman_period **out) TOLIMAN_NOEXCEPT;

/* The same to and from a file; saving replaces it as a whole or not at all (TOLIMAN_E_WRITE). Loading
 * reads the header first, and no more of a file that has not the size it tells. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_save_file(const toliman_period *period,
                                                                       const char *path) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_load_file(const char *path,
                                                                       toliman_period **out) TOLIMAN_NOEXCEPT;

/* How toliman_period_batch works. Since 0.1. */
typedef struct toliman_period_batch_options {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_PERIOD_..., default 0 */
    double
        tolerance; /* of every power, in [0, 0.01]; default 1e-9. Below 1e-13: direct sums only, which see to 1e-13 */
    uint32_t threads; /* own workers; 0 = one a processor. Never changes a bit of any result */
    uint32_t reserved;
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_period_batch_options;

/* Fills *options with the defaults. Since 0.1. */
TOLIMAN_API void toliman_period_batch_options_init(toliman_period_batch_options *options) TOLIMAN_NOEXCEPT;

/* Power of an archive of n samples at f0 + k df, k < nf, into power[nf]: model, weights and grid are those of a
 * streaming periodogram, there is no state. sigma and options may be NULL; n may be 0. Every power is within the
 * tolerance of the exact one, whatever the times, values and sigmas: a non-uniform FFT gives sums of known error, from
 * which the error of each power follows, and powers that are not good enough (few cycles in the time span, cosine and
 * sine that nearly coincide, weights of very different size) are repeated by compensated direct sums, or where these
 * cancel by exact ones. Small archives are summed directly, as is quicker. Special cases are as of query_power: the
 * power is 0 for constant values and 1 for as many free parameters as samples, and where the smaller eigenvalue of
 * cosine and sine is below 1e-17 of both they coincide. Memory while it runs: 35 bytes a sample and 170 a frequency, 20
 * more on each further thread up to six; 225 more a frequency if exact sums are needed. Same input, same bits on one
 * kind of processor: FFTW's last bits differ between kinds, those of direct sums do not. TOLIMAN_E_ARGUMENT for what is
 * not finite, sigma <= 0 and impossible grids; TOLIMAN_E_RANGE for another tolerance, |t| above 1e100, |y| above 1e300,
 * phases of more than 2^50 cycles, and where exact sums are needed but sigmas differ by more than 1e8;
 * TOLIMAN_E_MEMORY; TOLIMAN_E_CANCELLED. power is written as a whole or not at all. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_batch(double f0, double df, int64_t nf, const double *t,
                                                                   const double *y, const double *sigma, size_t n,
                                                                   const toliman_period_batch_options *options,
                                                                   double *power) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
