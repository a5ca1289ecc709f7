/* libtoliman, ingest: reads the mission's raw frames, clock tables, leap seconds and dates.
 *
 * Data flow (functions toliman_ingest_...)
 *
 *   options_init -> create <- X_frames.bin and X_meta.jsonl, complete or still growing
 *                     |
 *                   next, finish -> event -> frame -> track.h, cae.h, linear.h
 *                     |               +----> damage, warning, or nothing yet; reason_name
 *                   get_info, destroy
 *
 *   clock table           read_clock -> toliman_track_options.clock
 *   dates, Julian days    parse_time, convert_times -> TAI nanoseconds
 *   leap-seconds.list     read_leap_seconds -> parse_time, convert_times
 *
 * The mission writes a session as a pair of files: X_frames.bin holds the pixels without header, and X_meta.jsonl, the
 * side file, one JSON object per frame (formats.md, "The mission's pair of files"). Both files grow while the session
 * is downlinked. A damaged line or a missing frame is an event and does not end the reading.
 */
#ifndef TOLIMAN_INGEST_H
#define TOLIMAN_INGEST_H

#include <toliman/frame.h>

TOLIMAN_BEGIN_DECLS

/* Reader of one pair of files. Needs exclusive use. */
typedef struct toliman_ingest toliman_ingest;

/* Flags of toliman_ingest_options. */
#define TOLIMAN_INGEST_GROWING 1u /* the files may still grow: next returns NOTHING instead of an end; see finish */

/* Options of a reader. Since 0.2. */
typedef struct toliman_ingest_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_INGEST_GROWING */
    int32_t pixel;      /* type of the pixels: TOLIMAN_PIXEL_U16 or TOLIMAN_PIXEL_U32; there is no default */
    int32_t stamp;      /* TOLIMAN_FRAME_STAMP_..., 0 = START, as the mission writes it */
    double exposure_s;  /* length of an exposure, at most 1e9 s; 0 = unknown */
    int64_t rows, cols; /* expected shape of a frame. It locates the frames if lines of the side file are damaged;
                           0 = the shape in the first valid line */
    int64_t first_id;   /* frames with ids from first_id to end_id - 1 are read, all others are skipped. */
    int64_t end_id;     /* Both 0 = all frames */
    uint32_t buffers;   /* frames whose memory stays valid at the same time, 1 to 4096; 0 = 1 */
    uint32_t reserved;  /* 0 */
    const toliman_allocator *allocator; /* for the pixels; NULL = malloc */
} toliman_ingest_options;
#define TOLIMAN_INGEST_OPTIONS_INIT TOLIMAN_INIT(toliman_ingest_options)

/* Sets *options, a struct of `size` bytes, to the defaults. Since 0.2. */
TOLIMAN_API void toliman_ingest_options_init(toliman_ingest_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Opens a pair.
 *   path     one of the two files, or X, the path without _frames.bin and _meta.jsonl
 *   options  must not be NULL, as the pixel type has no default
 * Errors: TOLIMAN_E_NOT_FOUND if one of the files is missing or cannot be read. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_create(const char *path,
                                                                    const toliman_ingest_options *options,
                                                                    toliman_ingest **out) TOLIMAN_NOEXCEPT;

/* Destroys a reader and the memory of its frames. NULL is allowed. Since 0.2. */
TOLIMAN_API void toliman_ingest_destroy(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Events. */
#define TOLIMAN_INGEST_EVENT_NOTHING 611 /* no event until the files grow; without GROWING: end of the files */
#define TOLIMAN_INGEST_EVENT_FRAME 612   /* frame */
#define TOLIMAN_INGEST_EVENT_DAMAGE 613  /* frame that cannot be read */
#define TOLIMAN_INGEST_EVENT_WARNING 614 /* suspicious time or size; the next frame is valid */

/* Reasons of damage and warnings. */
#define TOLIMAN_INGEST_REASON_NONE 621
#define TOLIMAN_INGEST_REASON_BAD_LINE 622      /* DAMAGE: malformed line of the side file */
#define TOLIMAN_INGEST_REASON_SHORT_FILE 623    /* DAMAGE: the file of pixels ends before this frame */
#define TOLIMAN_INGEST_REASON_PLACE_UNKNOWN 624 /* DAMAGE: position in the file unknown, after a damaged line */
#define TOLIMAN_INGEST_REASON_CLOCK_JUMP 625    /* WARNING: time goes back, stops, or skips 1000 usual steps */
#define TOLIMAN_INGEST_REASON_CLOCKS_DIFFER 626 /* WARNING: camera clock and host clock drift apart; once per pair */
#define TOLIMAN_INGEST_REASON_EXTRA_BYTES 627   /* WARNING: pixels that belong to no line; after the last frame */

/* Returns the name of a reason ("bad line"), "?" for an unknown one. Static text. Since 0.2. */
TOLIMAN_API const char *toliman_ingest_reason_name(int32_t reason) TOLIMAN_NOEXCEPT;

/* Event of a reader. Its texts stay valid as long as the frame's memory. Since 0.2. */
typedef struct toliman_ingest_event {
    uint32_t struct_size; /* in: sizeof(toliman_ingest_event) */
    int32_t event;        /* TOLIMAN_INGEST_EVENT_... */
    int32_t reason;       /* TOLIMAN_INGEST_REASON_... */
    int32_t has_key;      /* 1 if session, roi and frame_id of the frame are known, also of a DAMAGE */
    const char *file;     /* path of the file that the event concerns, usually the side file; never NULL */
    int64_t line;         /* its line, from 1; 0 = the whole file */
    const char *text;     /* what is wrong, without file and line; "" for frames and NOTHING; never NULL */
    int64_t stamp_ns;     /* timestamp_ns of a valid line, as written; else 0 */
    double host_s;        /* host_time of a valid line, in s; else 0 */
} toliman_ingest_event;
#define TOLIMAN_INGEST_EVENT_INIT TOLIMAN_INIT(toliman_ingest_event)

/* Reads the next event.
 *   frame  becomes the frame of a FRAME event; for DAMAGE, what its line contains: all members but the pixels, of a
 *          BAD_LINE with has_key = 1 session, roi and frame_id only; else 0.
 *          camera_ns is the middle of the exposure by the camera clock: the stamp, plus or minus half the exposure. If
 *          the exposure is unknown, camera_ns is the stamp. Pixels and names belong to the reader and stay valid
 *          during the next `buffers` - 1 calls
 *   event  becomes the event
 * The struct_size of both must be set.
 * With GROWING, a call after NOTHING examines the files again and reads only what is new. If one of them has been
 * replaced by another file or truncated, reading starts again with its first frame.
 * Errors, after which next may be called again: TOLIMAN_E_NOT_FOUND if a file cannot be read or is truncated meanwhile;
 * TOLIMAN_E_FORMAT if the file has the size that frames of the other pixel type would have, or far more lines than
 * frames. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_next(toliman_ingest *ingest, toliman_frame *frame,
                                                                  toliman_ingest_event *event) TOLIMAN_NOEXCEPT;

/* Ends the growth of the files. Later calls of next report lines without pixels and pixels without line, then NOTHING.
 * They report neither if the files have changed since the last call of next, or between the last two that returned
 * NOTHING: they may still be growing. Not needed without GROWING. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_finish(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Properties and counts of a reader. Since 0.2. */
typedef struct toliman_ingest_info {
    uint32_t struct_size; /* in: sizeof(toliman_ingest_info) */
    int32_t stamp;        /* TOLIMAN_FRAME_STAMP_... */
    double exposure_s;
    int64_t lines;                      /* lines of the side file read so far */
    int64_t frames;                     /* FRAME events */
    int64_t damaged;                    /* DAMAGE events */
    int64_t warnings;                   /* WARNING events */
    int64_t skipped;                    /* frames outside first_id to end_id */
    uint64_t bytes;                     /* size of the file of pixels when it was last examined */
    const char *side_file, *pixel_file; /* paths; memory of the reader */
} toliman_ingest_info;
#define TOLIMAN_INGEST_INFO_INIT TOLIMAN_INIT(toliman_ingest_info)

/* Writes the properties and counts to *out, whose struct_size must be set. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_get_info(const toliman_ingest *ingest,
                                                                      toliman_ingest_info *out) TOLIMAN_NOEXCEPT;

/* Reads a clock table: lines camera_ns,tai_ns (formats.md, "Clock table").
 *   clock   [capacity][2], pairs for toliman_track_options.clock. To query the number, pass capacity 0 and clock NULL
 *   points  becomes the number of pairs
 *   log     receives a warning if a rate differs from 1 by more than 1 %, for instance for columns in other units or
 *           in the wrong order; may be NULL
 * Errors: TOLIMAN_E_NOT_FOUND, TOLIMAN_E_FORMAT with file and line, TOLIMAN_E_CAPACITY if capacity is too small.
 * Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_clock(const char *path, int64_t *clock,
                                                                        size_t capacity, size_t *points,
                                                                        toliman_log_fn log,
                                                                        void *user_data) TOLIMAN_NOEXCEPT;

/* Time scales. TDB differs from TT by less than 2 ms, and is treated as TT. */
#define TOLIMAN_INGEST_SCALE_UTC 631
#define TOLIMAN_INGEST_SCALE_TAI 632
#define TOLIMAN_INGEST_SCALE_TT 633
#define TOLIMAN_INGEST_SCALE_TDB 634
#define TOLIMAN_INGEST_SCALE_GPS 635

/* Formats of a time in text. */
#define TOLIMAN_INGEST_FORMAT_ISO 641 /* 2028-03-01, 2028-03-01T12:00:00.5; with a final Z only in UTC */
#define TOLIMAN_INGEST_FORMAT_MJD 642 /* Modified Julian Day, a decimal number */
#define TOLIMAN_INGEST_FORMAT_JD 643  /* Julian Day, a decimal number */

/* Row of a table of leap seconds. Since 0.2. */
typedef struct toliman_leap_second {
    uint32_t struct_size; /* sizeof(toliman_leap_second) */
    int32_t tai_utc_s;    /* TAI - UTC in s from that day on */
    int64_t mjd;          /* day on which it begins, at 0 h UTC */
} toliman_leap_second;
#define TOLIMAN_LEAP_SECOND_INIT TOLIMAN_INIT(toliman_leap_second)

/* Reads a table of leap seconds.
 *   path     a leap-seconds.list of the IERS; NULL = the table of the ERFA library
 *   table    [capacity]. To query the number, pass capacity 0 and table NULL
 *   count    becomes the number of rows
 *   expires  becomes the day (MJD) from which on leap seconds may be missing: the expiry of the file, or the first year
 *            that ERFA calls dubious; may be NULL
 * Errors: TOLIMAN_E_NOT_FOUND, TOLIMAN_E_FORMAT with file and line, TOLIMAN_E_CAPACITY if capacity is too small.
 * Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_leap_seconds(const char *path,
                                                                               toliman_leap_second *table,
                                                                               size_t capacity, size_t *count,
                                                                               int64_t *expires) TOLIMAN_NOEXCEPT;

/* Converts text to TAI nanoseconds since 1970-01-01T00:00:00 TAI, exact to the nanosecond.
 *   text    a time from 1958-01-01 to 2099-12-31; in UTC from 1972-01-01 on
 *   format  TOLIMAN_INGEST_FORMAT_...
 *   scale   TOLIMAN_INGEST_SCALE_... of the text
 *   table   [count] leap seconds, from 1972-01-01 on; NULL if count is 0: those of ERFA. Used with UTC only
 * Dates are truncated to the nanosecond, decimal days rounded. A UTC day with a leap second has 86,401 s, and so has
 * its Julian Day. After the last leap second of the table, TAI - UTC stays as it is.
 * Errors: TOLIMAN_E_FORMAT if the text is not such a time, TOLIMAN_E_RANGE outside the years. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_parse_time(const char *text, int32_t format, int32_t scale,
                                                                        const toliman_leap_second *table, size_t count,
                                                                        int64_t *tai_ns) TOLIMAN_NOEXCEPT;

/* Converts times[count], nanoseconds since 1970-01-01T00:00:00 of their scale, to TAI nanoseconds. In UTC every day
 * counts 86,400 s, as in POSIX and in NumPy's datetime64, so that the time after a leap second equals the second
 * before.
 *   scale          TOLIMAN_INGEST_SCALE_...
 *   table          [rows] leap seconds, as in toliman_ingest_parse_time
 *   tai_ns         [count]; may be `times`
 * Errors: TOLIMAN_E_RANGE outside the years of toliman_ingest_parse_time, naming the element. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_convert_times(const int64_t *times, size_t count,
                                                                           int32_t scale,
                                                                           const toliman_leap_second *table,
                                                                           size_t rows,
                                                                           int64_t *tai_ns) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
