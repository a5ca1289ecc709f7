/* libtoliman, measurements: one series of separations, or of other values, for every step from the frames to the
 * planets.
 *
 * Data flow (functions toliman_measure_...)
 *
 *   table, JSON, .npy file; state folder ------> load_file --+
 *   the bytes of such a file -------------------> load ------+-> toliman_measure -> toliman_sky_reduce    (sky.h)
 *   arrays -------------------------------------> create ----+    |                 toliman_sky_refit     (sky.h)
 *   tracker -> toliman_track_get_measure ---------------------+    |                 toliman_sky_diagnose
 *                                                                 |                 toliman_planet_create (planet.h)
 *                                                                 |                 toliman_measure_query_noise
 *                                                                 |                 query_instruments
 *     set_trend, add_column, set_instruments, set_prior ----------+
 *     -> functions fitted with the mean                           +-> get_info, get_function, get_values, get_times
 *                                                                destroy
 *
 * Kind         What the values are. Separations as they were measured are reduced to the orbit of the binary before
 *              periods and planets are searched in them: toliman_sky_reduce gives the reduced series, with the position
 *              angles of its dates, and the errors of the orbit as functions. Values in a state folder whose frames are
 *              reduced are reduced already.
 * Times        Plain numbers, or dates: Modified Julian Days of TAI, or of their own scale if they were not in UTC.
 * Exposures    Needed by toliman_sky_reduce and _refit: on-target intervals, or start and end of exposures whose
 *              on-target intervals are not known. Those of a state folder are in its ledger.
 * Unit         arcsec (velocities: m/s) per unit of the values and sigmas. The values keep their own unit.
 * Functions    Fitted with the mean, as in period_nuisance.h: the polynomials T_1 ... of a trend, then columns. At most
 *              32. A coefficient may have a Gaussian prior.
 * Frames       Of a state folder, in order of arrival. By default the values of all accepted frames, as in its sums,
 *              with the functions and priors of the sums. With kind TOLIMAN_MEASURE_SEPARATION the measured separations
 *              of accepted and unreduced frames, which need a fit; those whose time on target is not known are left
 *              out.
 */
#ifndef TOLIMAN_MEASURE_H
#define TOLIMAN_MEASURE_H

#include <toliman/series.h>

TOLIMAN_BEGIN_DECLS

/* A series of measurements. */
typedef struct toliman_measure toliman_measure;

/* Kinds of values. */
#define TOLIMAN_MEASURE_VALUE 901      /* any, such as latents */
#define TOLIMAN_MEASURE_SEPARATION 902 /* apparent separations, as they were measured */
#define TOLIMAN_MEASURE_REDUCED 903    /* separations reduced to the orbit of the binary */
#define TOLIMAN_MEASURE_VELOCITY 904   /* radial velocities of a star */

/* Measurements as arrays. */
typedef struct toliman_measure_data {
    uint32_t struct_size;
    int32_t kind; /* TOLIMAN_MEASURE_...; 0 = TOLIMAN_MEASURE_VALUE */
    size_t n;
    const double *t;               /* [n], times, in any order; NULL with intervals: Modified Julian Days of TAI of the
                                      middle between the first start and the last end */
    const double *y;               /* [n], values */
    const double *sigma;           /* [n], absolute standard deviations; NULL: not known */
    const int64_t *intervals;      /* [sum of interval_counts][2], on-target intervals, start and end, TAI ns; NULL:
                                      not known */
    const size_t *interval_counts; /* [n], number of intervals of each; NULL: one for each, from the start to the end
                                      of an exposure whose on-target intervals are not known */
    const double *position_angle_deg; /* [n], of B from A on the orbit, for planets; NULL: not known */
    double unit;                      /* arcsec (velocities: m/s) per unit of y; 0: not known, but 1 for separations */
    double time_unit_days;            /* days per unit of t; 0 = 1 */
    double frame_chi_square;          /* median chi_square of the frames that were measured; 0: not known */
} toliman_measure_data;
#define TOLIMAN_MEASURE_DATA_INIT TOLIMAN_INIT(toliman_measure_data)

/* Creates a series from arrays, which are copied. The caller destroys *out.
 * Errors: TOLIMAN_E_ARGUMENT, naming the array and the sample, if a number is not finite or above 1e100, for a sigma
 * or a measured separation that is not above 0, and if all intervals are near 1970-01-01, so that they are not in
 * nanoseconds. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_create(const toliman_measure_data *data,
                                                                     toliman_measure **out) TOLIMAN_NOEXCEPT;

/* How to read a file or a state folder. */
typedef struct toliman_measure_options {
    uint32_t struct_size;
    int32_t
        kind; /* TOLIMAN_MEASURE_...; 0 = VELOCITY if the file states a unit of velocity, otherwise VALUE, of a state folder REDUCED where it is. SEPARATION of a state folder: the measured separations */
    const char *columns; /* as toliman_series_options, likewise the next four; not for state folders */
    int32_t time_format;
    int32_t time_scale;
    const toliman_leap_second *leap_seconds;
    size_t leap_second_count;
    uint32_t flags; /* TOLIMAN_SERIES_PLAIN_TIMES */
    uint32_t reserved;
    double
        unit; /* as toliman_measure_data, in (0, 1e100]; 0 = that which the file states, if any. Of a state folder: arcsec per px
                    instead of its own plate scale, not for reduced frames */
    double
        exposure_s; /* length of each exposure, whose middle is t, in (0, 34560000] s; 0 = unknown. Times must be dates. Not for
                          state folders */
    const char *instrument; /* as toliman_series_options: the instruments of the series, as of
                               toliman_measure_set_instruments; not for state folders */
    toliman_log_fn log;     /* receives warnings; may be NULL */
    void *log_data;
} toliman_measure_options;
#define TOLIMAN_MEASURE_OPTIONS_INIT TOLIMAN_INIT(toliman_measure_options)

/* Reads a series from a file, or from a state folder of a tracker.
 *   path     a table or JSON Lines as in series.h, an array of JSON objects, a .npy table (float64 [n][2 or 3]: t, y,
 *            sigma), or a folder
 *   options  may be NULL
 * Warnings: rows without a value, which are skipped; a column of instruments; a last line without newline, whose last
 * number may be truncated; and those of series.h. A number that seems to mark a missing value (-9999) is an error
 * (promise: missing-marks-are-no-values). The caller destroys *out. Errors: TOLIMAN_E_NOT_FOUND if there is no such
 * file, and for a folder without such frames; TOLIMAN_E_FORMAT, with file and line, for a malformed line, and for a
 * file without samples; TOLIMAN_E_MISMATCH if the file has no such columns, or units that cannot be converted;
 * TOLIMAN_E_ARGUMENT for bad options, such as a unit that is not that of the file, and as toliman_measure_create; of a
 * folder as toliman_track_create. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_load_file(const char *path,
                                                                        const toliman_measure_options *options,
                                                                        toliman_measure **out) TOLIMAN_NOEXCEPT;

/* Reads the same series from the `size` bytes of such a file (promise: sources-give-same-numbers).
 *   name     of the input in messages; NULL: none */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_load(const void *bytes, size_t size, const char *name,
                                                                   const toliman_measure_options *options,
                                                                   toliman_measure **out) TOLIMAN_NOEXCEPT;

/* Destroys a series. NULL is allowed. */
TOLIMAN_API void toliman_measure_destroy(toliman_measure *measure) TOLIMAN_NOEXCEPT;

/* Fits the Chebyshev polynomials T_1 ... T_order of the time with the mean, in place of an earlier trend and its
 * priors.
 *   order       0 to 8; 0 removes the trend
 *   start, end  the span, in units of t; both 0: from the first to the last time
 * Errors: TOLIMAN_E_ARGUMENT for a bad order or span, or more than 32 functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_trend(toliman_measure *measure, int32_t order,
                                                                        double start, double end) TOLIMAN_NOEXCEPT;

/* Fits the values of a column, one for each sample, with the mean.
 *   name    up to 63 characters
 *   values  [n], copied
 *   n       number of samples
 *   sigma   standard deviation of the prior of its coefficient, in units of y per unit of the column; 0: no prior
 * Errors: TOLIMAN_E_ARGUMENT for bad numbers, a name that is used, or more than 32 functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_add_column(toliman_measure *measure, const char *name,
                                                                         const double *values, size_t n,
                                                                         double sigma) TOLIMAN_NOEXCEPT;

/* Sets the instruments of the samples: each has an offset, and a jitter in searches for planets. The offsets are
 * columns named "offset NAME", of all but the first instrument; those that were set before are replaced.
 *   names       list of the instruments' names, up to 56 characters each; "" removes them
 *   instrument  [n], index of the instrument of each sample; each has at least one
 *   n           number of samples
 * Errors: TOLIMAN_E_ARGUMENT for bad names or numbers, a name that is used, or more than 32 functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_instruments(toliman_measure *measure,
                                                                              const char *names,
                                                                              const int64_t *instrument,
                                                                              size_t n) TOLIMAN_NOEXCEPT;

/* Sets the standard deviation of the prior of a function's coefficient, in units of y per unit of the function; 0: no
 * prior. Errors: TOLIMAN_E_RANGE if `function` is not in [0, functions). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_set_prior(toliman_measure *measure, int64_t function,
                                                                        double sigma) TOLIMAN_NOEXCEPT;

/* Properties of a series. */
typedef struct toliman_measure_info {
    uint32_t struct_size;         /* in: sizeof(toliman_measure_info) */
    int32_t kind;                 /* TOLIMAN_MEASURE_... */
    int64_t n;                    /* samples */
    int64_t left_out;             /* of the source, that could not be used, such as rows without a value */
    int64_t functions;            /* without the mean: trend + columns */
    int32_t trend, columns;       /* highest order; number of columns */
    int32_t time_format;          /* TOLIMAN_INGEST_FORMAT_... in which dates were given; 0: plain numbers */
    int32_t time_scale;           /* TOLIMAN_INGEST_SCALE_... of t, Modified Julian Days; 0: plain numbers */
    int32_t is_weighted;          /* 1: has sigmas */
    int32_t has_exposures;        /* 1: exposures are known */
    int64_t instruments;          /* number; 0: not known */
    const char *instrument_names; /* of the instruments, a list; valid until the series is changed or destroyed */
    double trend_start, trend_end;
    double unit, time_unit_days, frame_chi_square; /* as in toliman_measure_data */
    double parallax_arcsec, star_mass[2];          /* of the system to which it is reduced; 0: not known */
    char unit_name[16];                            /* of y, as in toliman_series_info */
} toliman_measure_info;
#define TOLIMAN_MEASURE_INFO_INIT TOLIMAN_INIT(toliman_measure_info)

/* Writes the properties to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_info(const toliman_measure *measure,
                                                                       toliman_measure_info *out) TOLIMAN_NOEXCEPT;

/* An instrument in a fit. */
typedef struct toliman_measure_instrument {
    uint32_t struct_size;        /* in, in the first element: sizeof(toliman_measure_instrument) */
    int32_t source;              /* 0: of the series; 1, 2: of the velocities of A, B of a search for planets */
    int64_t samples;             /* in use */
    double offset, offset_error; /* from the first instrument of its source, units of its values; 0 for the first */
    double jitter[3];            /* 16, 50 and 84 %, units of its values; 0 without one */
    double chi_square, chi_square_sigma,
        largest_residual; /* as in goodness.h, without the jitter; NaN without sigmas */
    int32_t goodness;     /* TOLIMAN_GOODNESS_... of chi_square */
    uint32_t reserved;
    char name[64]; /* "" for the only one of a source */
} toliman_measure_instrument;
#define TOLIMAN_MEASURE_INSTRUMENT_INIT TOLIMAN_INIT(toliman_measure_instrument)

/* Fits mean, functions and a jitter of each instrument, as described in planet.h, without a planet, and writes the
 * instruments to instruments[capacity], one at least, and their number to *count. Errors: TOLIMAN_E_CAPACITY if
 * capacity is too small; otherwise as toliman_planet_create. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_instruments(const toliman_measure *measure,
                                                                                toliman_measure_instrument *instruments,
                                                                                size_t capacity,
                                                                                size_t *count) TOLIMAN_NOEXCEPT;

/* A function that is fitted with the mean. */
typedef struct toliman_measure_function {
    uint32_t struct_size; /* in: sizeof(toliman_measure_function) */
    uint32_t reserved;
    double sigma;  /* standard deviation of the prior of its coefficient; 0: no prior */
    double unit;   /* factor from its coefficient to the number that it stands for: the error of an element, in the unit
                     of its name, or 1 */
    double bound;  /* largest |value| of a column; 1 for a polynomial */
    char name[64]; /* "T1" ..., or the name of the column */
} toliman_measure_function;
#define TOLIMAN_MEASURE_FUNCTION_INIT TOLIMAN_INIT(toliman_measure_function)

/* Writes function `index` to *out, whose struct_size must be set. Errors: TOLIMAN_E_RANGE if index is not in
 * [0, functions). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_function(
    const toliman_measure *measure, int64_t index, toliman_measure_function *out) TOLIMAN_NOEXCEPT;

/* Writes one number for each sample.
 *   name      "t", "y", "sigma", "position_angle_deg", "instrument", the name of a function; of reduced series also
 *             "separation_arcsec" as it was measured, "factor" and "geometric_arcsec" of sky.h
 *   values    [n]
 *   n         number of samples
 * Errors: TOLIMAN_E_NOT_FOUND for a name that the series does not have; TOLIMAN_E_ARGUMENT for another n. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_values(const toliman_measure *measure,
                                                                         const char *name, double *values,
                                                                         size_t n) TOLIMAN_NOEXCEPT;

/* Writes the times in TAI, ns since 1970-01-01T00:00:00 TAI, to tai_ns[n]. Errors: TOLIMAN_E_ARGUMENT for plain
 * numbers, and for another n. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_get_times(const toliman_measure *measure, int64_t *tai_ns,
                                                                        size_t n) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
