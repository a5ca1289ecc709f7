/* libtoliman, ingest: reads the mission's raw frames, clock tables, leap seconds and dates.
 *
 * Data flow (toliman_ingest_...)
 *
 *   X_frames.bin and X_meta.jsonl, or X.nc -> create, destroy, get_info, netcdf_version
 *   next, finish -> event -> frame -> track.h, cae.h, linear.h
 *                        -> damage, warning, or nothing yet
 *   find_frame, set_shift    frames after lost bytes
 *
 *   clock table, on-target windows   read_clock, read_on_target -> track_options.h, frame.h, sky.h
 *   dates, Julian days, FITS header  parse_time, convert_times, read_header -> TAI nanoseconds
 *   leap-seconds.list                read_leap_seconds -> these; last_utc_day
 *
 * The mission writes a session as a pair of files: X_frames.bin holds the pixels, X_meta.jsonl, the side file, one JSON
 * object per frame (formats.md, "The mission's pair of files"); or in batches, netCDF files ("Batches of frames"). A
 * damaged line or a missing frame is an event and does not end the reading (promise: damaged-lines-are-events). */
#ifndef TOLIMAN_INGEST_H
#define TOLIMAN_INGEST_H

#include <toliman/frame.h>

TOLIMAN_BEGIN_DECLS

/* Reader of one pair or batch. No file is open after NOTHING. */
typedef struct toliman_ingest toliman_ingest;

#define TOLIMAN_INGEST_GROWING 1u /* the files may still grow; see toliman_ingest_next */

/* Options of a reader. */
typedef struct toliman_ingest_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_INGEST_GROWING */
    int32_t pixel;      /* TOLIMAN_PIXEL_U16 or TOLIMAN_PIXEL_U32; 0 = found in the files. Of a batch always U16 */
    int32_t stamp;      /* meaning of timestamp_ns: TOLIMAN_FRAME_STAMP_..., 0 = START, as the mission writes it */
    double exposure_s;  /* in (0, 1e9] s; 0 = unknown */
    int64_t rows, cols; /* expected shape, in [1, 65536]; both 0 = the shape in the first valid line. It locates the
                           frames after damaged lines */
    int64_t first_id;   /* smaller ids are skipped */
    int64_t end_id;     /* this and larger ids are skipped; both 0 = all frames. Malformed lines are reported unless
                           their id is readable and skipped */
    uint32_t buffers;   /* frames whose memory is valid at the same time, in [1, 4096]; 0 = 1 */
    uint32_t reserved;
    const toliman_allocator *allocator;
    const char *roi; /* region of interest whose frames are reported; NULL = all */
} toliman_ingest_options;
#define TOLIMAN_INGEST_OPTIONS_INIT TOLIMAN_INIT(toliman_ingest_options)

/* Creates a reader.
 *   path  one of the two files, or X; or a batch, X.nc, which must be complete: GROWING is ignored
 * Errors: TOLIMAN_E_NOT_FOUND also for what is not a regular file; TOLIMAN_E_UNSUPPORTED for a batch if the library was
 * built without netCDF. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_create(const char *path,
                                                                    const toliman_ingest_options *options,
                                                                    toliman_ingest **out) TOLIMAN_NOEXCEPT;

/* Destroys a reader and the memory of its frames, events and paths. */
TOLIMAN_API void toliman_ingest_destroy(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Events. */
#define TOLIMAN_INGEST_EVENT_NOTHING 611 /* with GROWING: nothing new; without: end of the files */
#define TOLIMAN_INGEST_EVENT_FRAME 612   /* valid frame */
#define TOLIMAN_INGEST_EVENT_DAMAGE 613  /* line whose frame cannot be read */
#define TOLIMAN_INGEST_EVENT_WARNING 614 /* suspicious time stamp, before its frame; or extra bytes */

/* Reasons, of DAMAGE up to PLACE_UNKNOWN, then of WARNING. */
#define TOLIMAN_INGEST_REASON_NONE 621
#define TOLIMAN_INGEST_REASON_BAD_LINE 622      /* malformed line of the side file */
#define TOLIMAN_INGEST_REASON_SHORT_FILE 623    /* the file of pixels ends before this frame */
#define TOLIMAN_INGEST_REASON_PLACE_UNKNOWN 624 /* position in the file unknown, after a damaged line */
#define TOLIMAN_INGEST_REASON_CLOCK_JUMP                                                                               \
    625                                         /* time stops, skips 1000 median steps, or goes back while the frame
                                                   id does not */
#define TOLIMAN_INGEST_REASON_CLOCKS_DIFFER 626 /* camera clock and host clock drift apart; once */
#define TOLIMAN_INGEST_REASON_EXTRA_BYTES 627   /* pixels without a line, after the last frame */
#define TOLIMAN_INGEST_REASON_OVERLAP 628       /* exposures of successive frames overlap; once */
#define TOLIMAN_INGEST_REASON_RESTART 629       /* restart of the camera before this frame */
#define TOLIMAN_INGEST_REASON_UNKNOWN_KEY 630   /* a line has a key that is not read; once */

/* Event of a reader. `file` is valid until the reader is destroyed, `text` as long as the memory of a frame. */
typedef struct toliman_ingest_event {
    uint32_t struct_size;
    int32_t event;
    int32_t reason;
    int32_t has_key;  /* 1 for FRAME, and for DAMAGE with known session, roi and frame_id; else 0 */
    const char *file; /* the side file; EXTRA_BYTES: the file of pixels; a batch: itself */
    int64_t line;     /* of the side file, or frame of the batch, from 1; else 0 */
    const char *text; /* what is wrong; "" for FRAME and NOTHING */
    int64_t stamp_ns; /* timestamp_ns as written, for FRAME, SHORT_FILE and PLACE_UNKNOWN; else 0 */
    double host_s;    /* host_time in s, likewise */
    int64_t offset;   /* byte of the file of pixels at which a FRAME begins by the lines before it, without the
                         shift; 0 in a batch */
} toliman_ingest_event;
#define TOLIMAN_INGEST_EVENT_INIT TOLIMAN_INIT(toliman_ingest_event)

/* Reads the next event. Frames come in the order of their lines, warnings about a line before its frame.
 *   frame  of a FRAME; of DAMAGE with has_key: session, roi and frame_id, and unless BAD_LINE also camera_ns, dropped,
 *          rows and cols. All else is 0
 *
 * Time: camera_ns is the middle of the exposure by the camera clock, rounded to 1 ns: timestamp_ns, plus half of
 * exposure_s for START, minus half of it for END; timestamp_ns if the exposure is unknown.
 *
 * Restarts (formats.md): after a reconnection of the camera frame_id begins again. restarts counts this, so that such
 * frames have keys of their own (promise: restarted-counters-lose-no-frame). Times of a clock that begins again are
 * moved to continue those before as host_time does: one clock table holds for the session.
 *
 * Pixel type, if it is not given: that of the key dtype of the lines. Without it, U32 if complete files have at least
 * 1.5 times the bytes of their frames as U16; otherwise U16, as the mission writes (promise: pixel-type-is-found).
 *
 * Intervals: those of on_target_s in the line, at most 64; NULL without. They need a known exposure (otherwise DAMAGE).
 *
 * Memory: pixels, intervals, names and texts belong to the reader and stay valid during the next `buffers` - 1 calls of
 * next (promise: frames-outlive-their-buffers).
 *
 * With GROWING, the first call and each call after NOTHING examine both files and read what is new. A frame is reported
 * once its line, with the newline, and all its pixels are in the files (promise: growing-pairs-lose-no-frame). After a
 * file was replaced, truncated, or overwritten with the same size, next returns NOTHING and then all frames from the
 * first one (promise: replaced-pairs-start-again). A file overwritten by a longer one seems to have grown. Without
 * GROWING, only the first call examines the files, and the last line needs no newline.
 *
 * Errors, after which next may be called again; it then examines the files, and starts again if they were replaced or
 * truncated:
 *   - TOLIMAN_E_NOT_FOUND also if a file is truncated while it is read;
 *   - TOLIMAN_E_FORMAT if a given pixel type contradicts the key dtype;
 *   - TOLIMAN_E_FORMAT if without this key the file of pixels has twice or half the size of all frames, as with the
 *     other pixel type, and no line has been reported; with GROWING, if two examinations in a row find this;
 *   - TOLIMAN_E_FORMAT if a side file of n bytes has more than 1024 + n/120 lines. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_next(toliman_ingest *ingest, toliman_frame *frame,
                                                                  toliman_ingest_event *event) TOLIMAN_NOEXCEPT;

/* Finds a frame that is not at its place, a misfit of a tracker, because the file of pixels has lost or gained bytes
 * before it.
 *   offset     of the frame's FRAME event
 *   reference  an undamaged frame of the same scene, shape and pixel type
 *   pixels     [rows][cols], receives the frame at the place where it is most similar to the reference; let the
 *              estimator confirm it
 *   size       of pixels, in bytes; TOLIMAN_E_CAPACITY if too small
 *   shift      receives the bytes from the frame's place to there; 0 if not found, always with GROWING and in a batch:
 *              pixels is unchanged */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_find_frame(const toliman_ingest *ingest, int64_t offset,
                                                                        const toliman_frame *reference, void *pixels,
                                                                        size_t size, int64_t *shift) TOLIMAN_NOEXCEPT;

/* Sets the shift, in bytes, at which the following frames are read; 0 at creation. No effect on a file of exactly the
 * size of all frames. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_set_shift(toliman_ingest *ingest,
                                                                       int64_t shift) TOLIMAN_NOEXCEPT;

/* Declares that the files no longer grow; no effect without GROWING. The following calls of next report what was found
 * before and end with NOTHING. Lines without pixels become DAMAGE, and pixels without line EXTRA_BYTES, unless the
 * files changed between their last two examinations or since: call next until it has returned NOTHING twice, with a
 * pause between, then finish. A last line without newline is not reported. Cannot be undone. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_finish(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Returns the version of netCDF, which reads batches ("4.9.0"); "" without. */
TOLIMAN_API const char *toliman_ingest_netcdf_version(void) TOLIMAN_NOEXCEPT;

/* Properties of a reader, and numbers of its events. */
typedef struct toliman_ingest_info {
    uint32_t struct_size;
    int32_t stamp;
    double exposure_s;
    int64_t lines; /* read from the side file since it was last replaced */
    int64_t frames;
    int64_t damaged;
    int64_t warnings;
    int64_t skipped;                    /* by first_id, end_id and roi */
    uint64_t bytes;                     /* of the file of pixels at the last examination; 0 before */
    const char *side_file, *pixel_file; /* paths, valid until the reader is destroyed; both that of a batch */
    int32_t pixel;                      /* TOLIMAN_PIXEL_... of the frames; 0 before the first valid line */
    uint32_t reserved;
} toliman_ingest_info;
#define TOLIMAN_INGEST_INFO_INIT TOLIMAN_INIT(toliman_ingest_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_get_info(const toliman_ingest *ingest,
                                                                      toliman_ingest_info *out) TOLIMAN_NOEXCEPT;

/* Reads a clock table: lines camera_ns,tai_ns (formats.md, "Clock table").
 *   clock  [capacity][2], pairs for toliman_track_clock
 *   log    receives a warning if a rate differs from 1 by more than 1 %: other units, or columns in the wrong order */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_clock(const char *path, int64_t *clock,
                                                                        size_t capacity, size_t *count,
                                                                        toliman_log_fn log,
                                                                        void *user_data) TOLIMAN_NOEXCEPT;

/* Time scales. TDB is treated as TT, from which it differs by 2 ms at most. */
#define TOLIMAN_INGEST_SCALE_UTC 631
#define TOLIMAN_INGEST_SCALE_TAI 632
#define TOLIMAN_INGEST_SCALE_TT 633
#define TOLIMAN_INGEST_SCALE_TDB 634
#define TOLIMAN_INGEST_SCALE_GPS 635

/* Formats of a time in text. */
#define TOLIMAN_INGEST_FORMAT_ISO 641 /* 2028-03-01, 2028-03-01T12:00:00.5, 2028-061 12:00:00 */
#define TOLIMAN_INGEST_FORMAT_MJD 642 /* Modified Julian Day: "61831.5" */
#define TOLIMAN_INGEST_FORMAT_JD 643  /* Julian Day: "2461832.0" */

/* Row of a table of leap seconds, 10 s on MJD 41317 (1972-01-01) in the first one; each further one is a later day and
 * 1 s more or less. Inputs `table` [count] may be NULL with 0: those of ERFA. */
typedef struct toliman_leap_second {
    uint32_t struct_size;
    int32_t tai_utc_s; /* TAI - UTC in s, from `mjd` on */
    int64_t mjd;       /* Modified Julian Day, at 0 h UTC */
} toliman_leap_second;
#define TOLIMAN_LEAP_SECOND_INIT TOLIMAN_INIT(toliman_leap_second)

/* Reads a table of leap seconds.
 *   path     a leap-seconds.list of the IERS; NULL = the table of the ERFA library
 *   expires  becomes the day (MJD) from which on leap seconds may be missing: expiry of the file, or of ERFA; may be
 *            NULL
 * A list of leap seconds is refused if it is damaged, truncated or not that of ERFA
 * (promise: leap-seconds-are-verified): TOLIMAN_E_FORMAT (formats.md, "Dates and time scales"). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_leap_seconds(const char *path,
                                                                               toliman_leap_second *table,
                                                                               size_t capacity, size_t *count,
                                                                               int64_t *expires) TOLIMAN_NOEXCEPT;

/* Returns the latest day (MJD) of UTC that any function has converted on this thread, 0 for none: to compare with
 * `expires` of toliman_ingest_read_leap_seconds at the end of a program. */
TOLIMAN_API int64_t toliman_ingest_last_utc_day(void) TOLIMAN_NOEXCEPT;

/* Converts text to TAI nanoseconds (formats.md, "Dates and time scales").
 *   text    a time from 1958-01-01 to 2099-12-31 of its scale, in UTC from 1972-01-01 on: YYYY-MM-DD or YYYY-DDD, alone
 *           (0 h) or with T or one blank and hh:mm:ss[.s...], in UTC also with Z or +00:00
 *   format  TOLIMAN_INGEST_FORMAT_...
 *   scale   TOLIMAN_INGEST_SCALE_...
 * Conversions of times are exact (promise: dates-are-exact): a date is truncated to the nanosecond, a decimal day
 * rounded to the nearest one. A UTC day that ends with a leap second has 86,401 s, and so has its Julian Day. After the
 * last row of the table, TAI - UTC remains constant.
 * Errors: TOLIMAN_E_FORMAT for other text, TOLIMAN_E_RANGE outside these years. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_parse_time(const char *text, int32_t format, int32_t scale,
                                                                        const toliman_leap_second *table, size_t count,
                                                                        int64_t *tai_ns) TOLIMAN_NOEXCEPT;

/* Reads on-target windows (formats.md, "On-target windows").
 *   leap_seconds  [leap_second_count], as `table`
 *   intervals     [capacity][2], start and end of each window, TAI nanoseconds, increasing; a window may begin where
 *                 the one before it ends */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_on_target(const char *path,
                                                                            const toliman_leap_second *leap_seconds,
                                                                            size_t leap_second_count,
                                                                            int64_t *intervals, size_t capacity,
                                                                            size_t *count) TOLIMAN_NOEXCEPT;

/* Keywords of a FITS header that give the time of its first frame: texts of the header, with or without quotes; NULL =
 * missing or without a value. */
typedef struct toliman_ingest_header {
    uint32_t struct_size;
    uint32_t reserved;
    const char *timesys; /* UTC, TAI, TT, TDT, ET, IAT, TDB, GPS or GMT, also as UTC(NIST); NULL = UTC */
    const char *mjd_avg, *date_avg, *mjd_beg, *mjd_obs, *date_obs;
    const char *xposure, *exptime; /* length of the exposure in s, 0 to 1e9 */
    const char *date_beg, *mjd_end, *date_end;
    const char *time_avg, *time_beg, *time_obs, *time_end; /* hh:mm:ss, to the dates of the same name */
    const char *utc_obs, *ut;                              /* hh:mm:ss, to DATE-OBS */
    const char *exposure;                                  /* as exptime; only with a time in the header */
    const char *telapse;                                   /* length from start to end in s, with pauses */
    const char *timeunit, *trefpos;                        /* unit of xposure and telapse; place of the times */
} toliman_ingest_header;
#define TOLIMAN_INGEST_HEADER_INIT TOLIMAN_INIT(toliman_ingest_header)

#define TOLIMAN_INGEST_ASSUMED 1u /* TIMESYS or the length is missing: UTC or mid-exposure is assumed */
#define TOLIMAN_INGEST_EXPIRED 2u /* UTC on the day `expires` or later */

/* Time of a header. */
typedef struct toliman_ingest_header_time {
    uint32_t struct_size;
    uint32_t flags;    /* TOLIMAN_INGEST_ASSUMED, _EXPIRED */
    int64_t tai_ns;    /* middle of the first exposure */
    char rule[120];    /* for messages: "MJD-OBS + EXPTIME/2 in TAI" */
    double exposure_s; /* from start to end; 0 = unknown */
} toliman_ingest_header_time;
#define TOLIMAN_INGEST_HEADER_TIME_INIT TOLIMAN_INIT(toliman_ingest_header_time)

/* Reads the time of the first frame from the keywords of a FITS header (formats.md, "FITS files that toliman track
 * reads"): the middle of the exposure if given, otherwise the start plus half of the length, otherwise the end minus
 * it. A start without length is taken as mid-exposure. All other times of a header must agree with the result within
 * half an exposure and their last digit (promise: contradicting-headers-are-refused).
 *   expires  of toliman_ingest_read_leap_seconds; ignored if count is 0
 * Errors: TOLIMAN_E_NOT_FOUND if the header has none of these times; with the keyword, TOLIMAN_E_FORMAT and
 * TOLIMAN_E_RANGE as toliman_ingest_parse_time, for contradictions (both keywords are named), a date without time, an
 * unknown TIMESYS, a bad length, and a TREFPOS outside the Earth. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_ingest_read_header(const toliman_ingest_header *header, const toliman_leap_second *table, size_t count,
                           int64_t expires, toliman_ingest_header_time *time) TOLIMAN_NOEXCEPT;

/* Converts times[count], nanoseconds since 1970-01-01T00:00:00 of their scale, to TAI nanoseconds. In UTC every day
 * counts 86,400 s, as in POSIX and NumPy's datetime64: a time within a leap second is converted as the time 1 s later.
 *   scale   TOLIMAN_INGEST_SCALE_...
 *   table   [rows]
 *   tai_ns  [count]; may be `times`, must not overlap it otherwise
 * Errors: TOLIMAN_E_RANGE outside the years of toliman_ingest_parse_time, naming the element. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_convert_times(const int64_t *times, size_t count,
                                                                           int32_t scale,
                                                                           const toliman_leap_second *table,
                                                                           size_t rows,
                                                                           int64_t *tai_ns) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
