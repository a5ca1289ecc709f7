/* libtoliman, series: parses the lines of a time series, text or JSON Lines, to samples for period.h.
 *
 * Data flow (toliman_series_...)
 *
 *   options -> create, destroy -> toliman_series -> get_info
 *   a line -> parse -> sample: t, y, sigma -> toliman_period_push
 *                   -> none: a comment, an empty line, a line of the header, or a row without a value
 *
 * The first lines determine the format of all (formats.md, "Series that toliman period reads": formats, names, units,
 * missing values):
 *
 *   1.5,0.25,0.1            columns t, y or t, y, sigma. More columns: the first three, with a warning; with GROWING an
 *                           error, as the line may be damaged
 *   t,latent,sigma          names of columns, in any order and among others, then such lines. Also in a comment
 *   {"t": 1.5, "y": 0.25}   objects with these keys among others
 *
 * Sigmas are converted to the unit of y. Rows without a value are skipped and counted. t and y are in [-1e98, 1e98],
 * sigmas in [1e-98, 1e98]. Times are plain numbers, or dates, Modified or Julian Days: these become Modified Julian
 * Days, of TAI if they are in UTC, otherwise of their own scale; resolution 0.6 us. */
#ifndef TOLIMAN_SERIES_H
#define TOLIMAN_SERIES_H

#include <toliman/ingest.h>

TOLIMAN_BEGIN_DECLS

/* Parser of the lines of one series. */
typedef struct toliman_series toliman_series;

#define TOLIMAN_SERIES_GROWING 1u     /* a last line without newline is malformed: it may be truncated */
#define TOLIMAN_SERIES_PLAIN_TIMES 2u /* times are plain numbers, also in a column named mjd or jd */

/* Options of a parser. */
typedef struct toliman_series_options {
    uint32_t struct_size;
    uint32_t flags;                          /* TOLIMAN_SERIES_GROWING, _PLAIN_TIMES */
    int32_t time_format;                     /* TOLIMAN_INGEST_FORMAT_...; 0 = dates if the first time begins as
                                                YYYY-MM-DD; otherwise by the name of the column (formats.md) */
    int32_t time_scale;                      /* TOLIMAN_INGEST_SCALE_... of dates and days; 0 = that of a column
                                                named bjd_tdb or alike, otherwise UTC */
    const char *name;                        /* of the input, for messages; may be NULL */
    const char *columns;                     /* names, or numbers from 1, of t, y and perhaps sigma; NULL = the usual
                                                names */
    const toliman_leap_second *leap_seconds; /* [leap_second_count] */
    size_t leap_second_count;                /* 0 = those of ERFA */
    const char *instrument;                  /* name, or number from 1, of the column of instruments; NULL = none */
    toliman_log_fn log;                      /* receives each warning once */
    void *log_data;
} toliman_series_options;
#define TOLIMAN_SERIES_OPTIONS_INIT TOLIMAN_INIT(toliman_series_options)

/* Creates a parser. Texts and leap seconds of its options are copied. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_create(const toliman_series_options *options,
                                                                    toliman_series **out) TOLIMAN_NOEXCEPT;

/* Destroys a parser. */
TOLIMAN_API void toliman_series_destroy(toliman_series *series) TOLIMAN_NOEXCEPT;

/* Result of a line. */
typedef struct toliman_series_sample {
    uint32_t struct_size;
    int32_t found;      /* 1: a sample */
    double t, y, sigma; /* sigma is 0 if there is none */
    int64_t instrument; /* in order of first appearance; -1: not known */
} toliman_series_sample;
#define TOLIMAN_SERIES_SAMPLE_INIT TOLIMAN_INIT(toliman_series_sample)

/* Parses the next line.
 *   line  [length] bytes, with its newline if the input has it; at most 65,536 without it (of a longer line, pass
 *         65,537). NULL if length is 0
 * Errors: TOLIMAN_E_FORMAT for a malformed line; it counts as a line, and the next one can be parsed
 * (promise: bad-lines-end-no-series). TOLIMAN_E_MISMATCH no such columns. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_parse(toliman_series *series, const char *line,
                                                                   size_t length,
                                                                   toliman_series_sample *sample) TOLIMAN_NOEXCEPT;

/* Properties of the lines parsed so far. */
typedef struct toliman_series_info {
    uint32_t struct_size;
    int32_t time_format; /* TOLIMAN_INGEST_FORMAT_...; 0 for plain numbers and before the first time */
    int32_t time_scale;  /* TOLIMAN_INGEST_SCALE_... of the samples, never UTC; 0 if time_format is 0 */
    int32_t truncated;   /* 1 if the last sample has no newline: its last number may be truncated */
    int64_t lines;       /* with empty and malformed ones */
    int64_t missing;     /* rows skipped without a value */
    int64_t instruments;
    char unit_name[16];         /* of y: "m/s", "km/s", "cm/s", "mas", "uas", "arcsec", "deg", "px" or as in the
                                   input; "": none */
    char likely_instrument[64]; /* column that seems to name instruments, unless options.instrument is given; "":
                                   none */
} toliman_series_info;
#define TOLIMAN_SERIES_INFO_INIT TOLIMAN_INIT(toliman_series_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_series_get_info(const toliman_series *series,
                                                                      toliman_series_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
