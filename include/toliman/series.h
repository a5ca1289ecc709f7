/* libtoliman, series: parses the lines of a time series, text or JSON Lines, to samples for period.h.
 *
 * Data flow (functions toliman_series_...)
 *
 *                   create <- name of the input, names of its columns, format and scale of its times
 *                     |
 *     a line ----> parse -> sample: t, y, sigma -> toliman_period_push
 *                     +---> none: a comment, an empty line, a line of the header, or a row without a value
 *                     |
 *                  get_info, destroy
 *
 * The caller reads the lines, from a file, a pipe or a socket, and passes them one by one. The first lines determine
 * the format of all:
 *
 *   1.5,0.25,0.1            columns t, y or t, y, sigma, separated by commas, semicolons, tabs or white space; of more
 *                           columns the first three, with a warning. With GROWING more columns are an error, as the
 *                           line may be damaged
 *   t,latent,sigma          names of the columns, in any order and among others, then such lines. The names may also be
 *                           in a comment before the first row: # t y sigma
 *   {"t": 1.5, "y": 0.25}   objects with these keys among others
 *
 * Headers      ECSV; byte-by-byte descriptions of VizieR, CDS and the AAS; IPAC; rdb. Below the names: lines of units,
 *              of types, of dashes. Text behind a blank and # is a comment. +- or the sign plus-minus may be between
 *              value and sigma. Between tabs, semicolons or blanks, numbers may have a decimal comma.
 * Names        Without `columns`: t, y and sigma; otherwise usual names, in upper or lower case, such as time, mjd, bjd
 *              or "BJD - 2450000" for t, value, rv, vrad or separation for y, err, e_rv or svrad for sigma. Two columns
 *              that could both be meant are an error.
 * Units        Of the header, of a line of units, or in brackets: "rv (m/s)". Sigmas are converted to the unit of y.
 * Missing      Empty, nan, -, --, ..., null, n/a, masked, and the null value that a header states: the row is skipped
 *              and counted. A number such as -9999 or 99.99, far from all others, causes a warning.
 * Range        t and y are in [-1e98, 1e98] and sigmas in [1e-98, 1e98], so that neither differences nor squares
 *              overflow.
 * Times        Plain numbers, dates, Modified Julian Days or Julian Days. Dates and days become Modified Julian Days of
 *              TAI if they are in UTC, whose days differ in length, otherwise of their own scale. As double they
 *              resolve 0.6 us.
 */
#ifndef TOLIMAN_SERIES_H
#define TOLIMAN_SERIES_H

#include <toliman/ingest.h>

TOLIMAN_BEGIN_DECLS

/* Parser of the lines of one series. */
typedef struct toliman_series toliman_series;

/* Flags of toliman_series_options. */
#define TOLIMAN_SERIES_GROWING 1u     /* a line without newline at its end may be truncated and is malformed */
#define TOLIMAN_SERIES_PLAIN_TIMES 2u /* times are plain numbers, also in a column named mjd or jd */

/* Options of a parser. */
typedef struct toliman_series_options {
    uint32_t struct_size;
    uint32_t flags;      /* TOLIMAN_SERIES_GROWING, _PLAIN_TIMES */
    int32_t time_format; /* TOLIMAN_INGEST_FORMAT_...; 0 = dates if the first time begins as YYYY-MM-DD; otherwise
                            Modified or Julian Days if the column is named mjd, jd, bjd, rjd, "BJD - 2450000" or alike;
                            otherwise numbers. Julian Days near 59000 are taken as JD - 2400000, with a warning */
    int32_t time_scale;  /* TOLIMAN_INGEST_SCALE_... of dates and days; 0 = that of a column named bjd_tdb or alike,
                            otherwise UTC; not used for plain numbers */
    const char *name;    /* name of the input: messages begin with "name:line: "; NULL = without */
    const char *columns; /* names, or numbers from 1, of two or three columns or keys, "t,latent" or "t,latent,sigma";
                            NULL = the usual names */
    const toliman_leap_second *leap_seconds; /* [leap_second_count], as in toliman_ingest_parse_time */
    size_t leap_second_count;                /* 0 = the leap seconds of ERFA; leap_seconds may then be NULL */
    const char *instrument; /* name, or number from 1, of the column that names the instrument; NULL = none */
    toliman_log_fn log;     /* receives warnings, each once; may be NULL */
    void *log_data;
} toliman_series_options;
#define TOLIMAN_SERIES_OPTIONS_INIT TOLIMAN_INIT(toliman_series_options)

/* Creates a parser.
 *   options  NULL = the defaults. Texts and leap seconds are copied
 * The caller destroys *out. Errors: TOLIMAN_E_ARGUMENT, naming the option. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_create(const toliman_series_options *options,
                                                                    toliman_series **out) TOLIMAN_NOEXCEPT;

/* Destroys a parser. NULL is allowed. */
TOLIMAN_API void toliman_series_destroy(toliman_series *series) TOLIMAN_NOEXCEPT;

/* Result of a line. */
typedef struct toliman_series_sample {
    uint32_t struct_size; /* in: sizeof(toliman_series_sample) */
    int32_t found;        /* 1: the line is a sample; 0: a comment, a line of the header, or a row without a value */
    double t, y, sigma;   /* sigma is 0 if the series has none; all are 0 unless found is 1 */
    int64_t instrument;   /* index of the sample's instrument, in order of first appearance; -1 if it is not known */
} toliman_series_sample;
#define TOLIMAN_SERIES_SAMPLE_INIT TOLIMAN_INIT(toliman_series_sample)

/* Parses the next line.
 *   line    [length] bytes, with the newline at its end if the input has it; at most 65,536 bytes without it. A caller
 *           whose lines are longer may pass 65,537 bytes of one. NULL if length is 0
 *   sample  its struct_size must be set
 * Errors: TOLIMAN_E_FORMAT for a malformed line; it counts as a line, and the next one can be parsed
 * (promise: bad-lines-end-no-series). TOLIMAN_E_MISMATCH if the input has no such columns. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_parse(toliman_series *series, const char *line,
                                                                   size_t length,
                                                                   toliman_series_sample *sample) TOLIMAN_NOEXCEPT;

/* Properties of the lines that were parsed. */
typedef struct toliman_series_info {
    uint32_t struct_size; /* in: sizeof(toliman_series_info) */
    int32_t time_format; /* TOLIMAN_INGEST_FORMAT_... of the times, 0 for plain numbers and before the first time. Until
                            the first sample, every line determines it again */
    int32_t time_scale;  /* TOLIMAN_INGEST_SCALE_... of the samples' Modified Julian Days, never UTC; 0 if time_format
                            is 0 */
    int32_t truncated;   /* 1 if the last sample is columns without newline: its last number may be truncated */
    int64_t lines;       /* lines, including empty and malformed ones */
    int64_t missing;     /* rows that were skipped because they have no t, y or sigma */
    int64_t instruments; /* number of different texts in the column options.instrument */
    char unit_name[16];  /* unit of y that the input states, "m/s", "km/s", "cm/s", "mas", "uas", "arcsec", "deg", "px",
                            or its text if it is another one; "" if it states none */
    char likely_instrument[64]; /* column that seems to name several instruments, unless options.instrument is given;
                                   "" if there is none */
} toliman_series_info;
#define TOLIMAN_SERIES_INFO_INIT TOLIMAN_INIT(toliman_series_info)

/* Writes the properties to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_get_info(const toliman_series *series,
                                                                      toliman_series_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
