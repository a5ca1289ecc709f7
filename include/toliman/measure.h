/* libtoliman, measurements: one series of separations, or of other values, for every step from the frames to the
 * planets.
 *
 * Data flow (toliman_measure_...)
 *
 *   file, state folder -> load_file; its bytes -> load; arrays -> create; toliman_track_get_measure -> toliman_measure
 *   toliman_measure, other arrays -> create -> a changed copy
 *   functions     set_trend, add_column, set_instruments, set_prior
 *   properties    get_info, get_function, get_values, get_times; query_instruments; destroy
 *   toliman_measure -> sky.h, planet.h, period_noise.h
 *
 * Times        Plain numbers, or dates: Modified Julian Days of TAI, or of their own scale if they were not in UTC.
 * Exposures    On-target intervals, or start and end if these are not known; for toliman_sky_reduce and _refit.
 * Functions    Fitted with the mean, as in period_nuisance.h: T_1 ... of a trend, then columns. At most 32 (else
 *              TOLIMAN_E_ARGUMENT).
 * Frames       Of a state folder, in order of arrival: the values of accepted frames, with its functions and priors;
 *              with TOLIMAN_MEASURE_SEPARATION the measured separations of accepted and unreduced frames whose
 *              on-target time is known. */
#ifndef TOLIMAN_MEASURE_H
#define TOLIMAN_MEASURE_H

#include <toliman/series.h>

TOLIMAN_BEGIN_DECLS

/* Series of measurements. */
typedef struct toliman_measure toliman_measure;

#define TOLIMAN_MEASURE_VALUE 901      /* any, such as latents */
#define TOLIMAN_MEASURE_SEPARATION 902 /* apparent, as measured; periods and planets need REDUCED */
#define TOLIMAN_MEASURE_REDUCED 903    /* reduced to the orbit of the binary, as frames of a state folder */
#define TOLIMAN_MEASURE_VELOCITY 904   /* radial velocities of a star */

/* Measurements as arrays. NULL or 0: not known, or as in `original`. */
typedef struct toliman_measure_data {
    uint32_t struct_size;
    int32_t kind; /* TOLIMAN_MEASURE_...; 0 = VALUE */
    size_t n;
    const double *t;                  /* [n], times, in any order; NULL with intervals: Modified Julian Days of TAI
                                         of the middle between the first start and the last end */
    const double *y;                  /* [n] */
    const double *sigma;              /* [n], absolute */
    const int64_t *intervals;         /* [sum of interval_counts][2], on-target intervals, start and end, TAI ns */
    const size_t *interval_counts;    /* [n], intervals of each; NULL: one each, start and end of an exposure whose
                                         on-target intervals are not known */
    const double *position_angle_deg; /* [n], of B from A on the orbit, for planets */
    double unit;                      /* arcsec (velocities: m/s) per unit of y and sigma; 0: 1 for separations */
    double time_unit_days;            /* days per unit of t; 0 = 1 */
    double frame_chi_square;          /* median of the measured frames */
    const char *name;                 /* of the source, as in toliman_measure_info */
    const toliman_measure *original;  /* a series that is copied, with its functions, before these members replace its
                                         own. t: its dates become plain numbers, and it loses trend and intervals */
} toliman_measure_data;
#define TOLIMAN_MEASURE_DATA_INIT TOLIMAN_INIT(toliman_measure_data)

/* Creates a series from arrays, which are copied.
 * Errors: TOLIMAN_E_ARGUMENT, naming array and sample: a number above 1e100, sigma or measured separation <= 0,
 * intervals not in ns. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_create(const toliman_measure_data *data,
                                                                     toliman_measure **out) TOLIMAN_NOEXCEPT;

/* How to read a file or a state folder. (f): files only, as toliman_series_options. */
typedef struct toliman_measure_options {
    uint32_t struct_size;
    int32_t kind;        /* TOLIMAN_MEASURE_...; 0 = VELOCITY if the file states a unit of velocity, REDUCED for a
                            state folder of reduced frames, otherwise VALUE */
    const char *columns; /* (f), like the next four */
    int32_t time_format;
    int32_t time_scale;
    const toliman_leap_second *leap_seconds;
    size_t leap_second_count;
    uint32_t flags; /* TOLIMAN_SERIES_PLAIN_TIMES; of a state folder: t in units of its grid since its time 0 */
    uint32_t reserved;
    double unit;            /* as toliman_measure_data, in (0, 1e100]; 0 = that which the file states, if any. Of a
                               state folder: arcsec per px instead of its own plate scale, not for reduced frames */
    double exposure_s;      /* files only: length of each exposure, whose middle is the date t, in (0, 34560000] s; 0
                               = unknown */
    const char *instrument; /* (f), for toliman_measure_set_instruments */
    const char *functions;  /* files only: path of a CSV table of columns, as of toliman_measure_add_column: a line of
                               names t,NAME,... and a row for each sample, with its time */
    toliman_log_fn log;     /* receives warnings */
    void *log_data;
} toliman_measure_options;
#define TOLIMAN_MEASURE_OPTIONS_INIT TOLIMAN_INIT(toliman_measure_options)

/* Reads a series from a file, or from a state folder of a tracker.
 *   path  table or JSON Lines (series.h), JSON array of objects, .npy (float64 [n][2 or 3]: t, y, sigma), or folder
 * A number that seems to mark a missing value (-9999) is an error (promise: missing-marks-are-no-values). Warnings:
 * rows without a value, and those of series.h.
 * Errors: as toliman_measure_create; folders as toliman_track_create; TOLIMAN_E_NOT_FOUND also without such frames in
 * the folder; TOLIMAN_E_FORMAT also without samples; TOLIMAN_E_MISMATCH no such columns, or units that cannot be
 * converted. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_load_file(const char *path,
                                                                        const toliman_measure_options *options,
                                                                        toliman_measure **out) TOLIMAN_NOEXCEPT;

/* Reads the same series from the bytes of such a file (promise: sources-give-same-numbers). name, in messages, may
 * be NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_load(const void *bytes, size_t size, const char *name,
                                                                   const toliman_measure_options *options,
                                                                   toliman_measure **out) TOLIMAN_NOEXCEPT;

/* Destroys a series. */
TOLIMAN_API void toliman_measure_destroy(toliman_measure *measure) TOLIMAN_NOEXCEPT;

/* Fits Chebyshev polynomials T_1 ... T_order of the time with the mean, in place of an earlier trend and its priors.
 *   order       0 (none) to 8
 *   start, end  the span, in units of t; both 0: first to last time */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_trend(toliman_measure *measure, int32_t order,
                                                                        double start, double end) TOLIMAN_NOEXCEPT;

/* Fits a column with the mean.
 *   name    up to 63 characters
 *   values  [n], copied
 *   sigma   standard deviation of the prior of its coefficient, units of y per unit of the column; 0: no prior */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_add_column(toliman_measure *measure, const char *name,
                                                                         const double *values, size_t n,
                                                                         double sigma) TOLIMAN_NOEXCEPT;

/* Sets the instruments of the samples, instead of earlier ones. Each has an offset (columns "offset NAME" of all but
 * the first), and a jitter in searches for planets.
 *   names       list of names, up to 56 characters each; "" removes all
 *   instrument  [n], index of the instrument of each sample; each is used */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_instruments(toliman_measure *measure,
                                                                              const char *names,
                                                                              const int64_t *instrument,
                                                                              size_t n) TOLIMAN_NOEXCEPT;

/* Sets the standard deviation of the prior of a coefficient, units of y per unit of the function; 0: no prior. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_prior(toliman_measure *measure, int64_t function,
                                                                        double sigma) TOLIMAN_NOEXCEPT;

/* Properties of a series. 0: not known. */
typedef struct toliman_measure_info {
    uint32_t struct_size;
    int32_t kind;
    int64_t n;
    int64_t left_out;  /* of the source, such as rows without a value */
    int64_t functions; /* without the mean: trend + columns */
    int32_t trend, columns;
    int32_t time_format; /* TOLIMAN_INGEST_FORMAT_... of the dates given; 0: plain numbers */
    int32_t time_scale;  /* TOLIMAN_INGEST_SCALE_... of t; 0: plain numbers */
    int32_t is_weighted;
    int32_t has_exposures;
    int64_t instruments;
    const char *instrument_names; /* list; valid until the series is changed or destroyed */
    double trend_start, trend_end;
    double unit, time_unit_days, frame_chi_square; /* as in toliman_measure_data */
    double parallax_arcsec, star_mass[2];          /* of the system to which it is reduced */
    char unit_name[16];                            /* of y, as in toliman_series_info */
    int32_t is_refitted; /* 1: its orbit was refitted to measurements of these dates, no search (sky.h) */
    int32_t reserved;
    const char *name; /* file, folder or name of the source, "" if not known; as instrument_names */
} toliman_measure_info;
#define TOLIMAN_MEASURE_INFO_INIT TOLIMAN_INIT(toliman_measure_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_info(const toliman_measure *measure,
                                                                       toliman_measure_info *out) TOLIMAN_NOEXCEPT;

/* Instrument in a fit. */
typedef struct toliman_measure_instrument {
    uint32_t struct_size;
    int32_t source;              /* 0: series; 1, 2: velocities of A, B */
    int64_t samples;             /* in use */
    double offset, offset_error; /* from the first instrument of its source, units of y; 0 for the first */
    double jitter[3];            /* 16, 50 and 84 % points, units of y; 0 without one */
    /* goodness.h, without the jitter; NaN without sigmas */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;
    uint32_t reserved;
    char name[64]; /* "" for the only one of a source */
} toliman_measure_instrument;
#define TOLIMAN_MEASURE_INSTRUMENT_INIT TOLIMAN_INIT(toliman_measure_instrument)

/* Fits mean, functions and a jitter of each instrument (planet.h), without a planet, and writes the instruments, one at
 * least. Errors: as toliman_planet_create. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_instruments(const toliman_measure *measure,
                                                                                toliman_measure_instrument *instruments,
                                                                                size_t capacity,
                                                                                size_t *count) TOLIMAN_NOEXCEPT;

/* Function fitted with the mean. */
typedef struct toliman_measure_function {
    uint32_t struct_size;
    uint32_t reserved;
    double sigma;  /* of the prior; 0: no prior */
    double unit;   /* factor from the coefficient to the error of an element, in the unit of its name; otherwise 1 */
    double bound;  /* largest |value| of a column; 1 for a polynomial */
    char name[64]; /* "T1" ..., or the name of the column */
} toliman_measure_function;
#define TOLIMAN_MEASURE_FUNCTION_INIT TOLIMAN_INIT(toliman_measure_function)

/* Writes function `index`. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_function(
    const toliman_measure *measure, int64_t index, toliman_measure_function *out) TOLIMAN_NOEXCEPT;

/* Writes one number per sample to values[n].
 *   name  "t", "y", "sigma", "position_angle_deg", "instrument" or a function; of reduced series also
 *         "separation_arcsec" as measured, "factor", "geometric_arcsec" (sky.h)
 * Errors: TOLIMAN_E_NOT_FOUND no such name. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_values(const toliman_measure *measure,
                                                                         const char *name, double *values,
                                                                         size_t n) TOLIMAN_NOEXCEPT;

/* Writes the times to tai_ns[n]. Errors: TOLIMAN_E_ARGUMENT plain numbers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_times(const toliman_measure *measure, int64_t *tai_ns,
                                                                        size_t n) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
