/* libtoliman, ingest: reads the mission's raw frames, clock tables, leap seconds and dates.
 *
 * Data flow (functions toliman_ingest_...)
 *
 *                   create <- X_frames.bin and X_meta.jsonl, complete or still growing; X.nc
 *                     |
 *                   next, finish -> event -> frame -> track.h, cae.h, linear.h
 *                     |  ^ find_frame, set_shift: after bytes were lost
 *                     |               +----> damage, warning, or nothing yet
 *                   get_info, destroy; netcdf_version
 *
 *   clock table           read_clock -> toliman_track_clock
 *   on-target windows     read_on_target -> TAI nanoseconds, for toliman_frame.intervals and sky.h
 *   dates, Julian days    parse_time, convert_times -> TAI nanoseconds
 *   FITS keywords         read_header -> TAI nanoseconds of the first frame
 *   leap-seconds.list     read_leap_seconds -> parse_time, convert_times, read_header, read_on_target; last_utc_day
 *
 * The mission writes a session as a pair of files: X_frames.bin holds the pixels without header, and X_meta.jsonl, the
 * side file, one JSON object per frame (formats.md, "The mission's pair of files"). Both files grow while the session
 * is downlinked. A damaged line or a missing frame is an event and does not end the reading
 * (promise: damaged-lines-are-events). For the downlink, batches of frames are compressed to netCDF files
 * (formats.md, "Batches of frames"); the same reader gives their frames. */
#ifndef TOLIMAN_INGEST_H
#define TOLIMAN_INGEST_H

#include <toliman/frame.h>

TOLIMAN_BEGIN_DECLS

/* Reader of one pair of files, or of one batch. No file is open after NOTHING, so that one process can follow thousands
 * of pairs. */
typedef struct toliman_ingest toliman_ingest;

/* Flags of toliman_ingest_options. */
#define TOLIMAN_INGEST_GROWING 1u /* the files may still grow; see toliman_ingest_next and toliman_ingest_finish */

/* Options of a reader. */
typedef struct toliman_ingest_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_INGEST_GROWING */
    int32_t pixel;      /* type of the pixels of a pair: TOLIMAN_PIXEL_U16 or TOLIMAN_PIXEL_U32; there is no default.
                           Those of a batch are U16 */
    int32_t stamp;      /* meaning of timestamp_ns: TOLIMAN_FRAME_STAMP_..., 0 = START, as the mission writes it */
    double exposure_s;  /* length of an exposure, in (0, 1e9] s; 0 = unknown */
    int64_t rows, cols; /* expected shape of a frame, in [1, 65536]; both 0 = the shape in the first valid line. If
                           lines of the side file are damaged, it gives the positions of the frames */
    int64_t first_id;   /* frames with ids from first_id to end_id - 1 are reported, others are skipped. Malformed */
    int64_t end_id;     /* lines are reported unless their id is readable and outside. Both 0 = all frames */
    uint32_t buffers;   /* frames whose memory stays valid at the same time, in [1, 4096]; 0 = 1 */
    uint32_t reserved;  /* 0 */
    const toliman_allocator *allocator; /* for the pixels; NULL = malloc */
    const char *roi; /* frames of this region of interest are reported, others are skipped; NULL = all */
} toliman_ingest_options;
#define TOLIMAN_INGEST_OPTIONS_INIT TOLIMAN_INIT(toliman_ingest_options)

/* Creates a reader of a pair or a batch. The files must exist; toliman_ingest_next reads those of a pair.
 *   path     one of the two files, or X, the path without _frames.bin and _meta.jsonl; or a batch, X.nc, which must be
 *            complete: GROWING is ignored
 *   options  must not be NULL, as the pixel type has no default
 * The caller destroys *out. Errors: TOLIMAN_E_NOT_FOUND if one of the files is missing, is not a regular file or cannot
 * be opened; for a batch, TOLIMAN_E_FORMAT with the reason if it is damaged or has other contents, and
 * TOLIMAN_E_UNSUPPORTED if the library was built without netCDF. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_create(const char *path,
                                                                    const toliman_ingest_options *options,
                                                                    toliman_ingest **out) TOLIMAN_NOEXCEPT;

/* Destroys a reader and the memory of its frames, events and paths. NULL is allowed. */
TOLIMAN_API void toliman_ingest_destroy(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Events. */
#define TOLIMAN_INGEST_EVENT_NOTHING 611 /* with GROWING: nothing new at present; without: end of the files */
#define TOLIMAN_INGEST_EVENT_FRAME 612   /* valid frame */
#define TOLIMAN_INGEST_EVENT_DAMAGE 613  /* line whose frame cannot be read */
#define TOLIMAN_INGEST_EVENT_WARNING 614 /* suspicious time stamp, whose frame follows; or extra bytes */

/* Reasons of damage and warnings. */
#define TOLIMAN_INGEST_REASON_NONE 621
#define TOLIMAN_INGEST_REASON_BAD_LINE 622      /* DAMAGE: malformed line of the side file */
#define TOLIMAN_INGEST_REASON_SHORT_FILE 623    /* DAMAGE: the file of pixels ends before this frame */
#define TOLIMAN_INGEST_REASON_PLACE_UNKNOWN 624 /* DAMAGE: position in the file unknown, after a damaged line */
#define TOLIMAN_INGEST_REASON_CLOCK_JUMP                                                                               \
    625                                         /* WARNING: time stops, skips 1000 median steps, or goes
                                                   back while the frame id does not */
#define TOLIMAN_INGEST_REASON_CLOCKS_DIFFER 626 /* WARNING: camera clock and host clock drift apart; only once */
#define TOLIMAN_INGEST_REASON_EXTRA_BYTES 627   /* WARNING: pixels without a line, after those of the last frame */
#define TOLIMAN_INGEST_REASON_OVERLAP 628       /* WARNING: exposures of successive frames overlap; only once */
#define TOLIMAN_INGEST_REASON_RESTART 629       /* WARNING: the camera has restarted before this frame */
#define TOLIMAN_INGEST_REASON_UNKNOWN_KEY 630   /* WARNING: a line has a key that is not read; only once */

/* Event of a reader. `file` is valid until the reader is destroyed, `text` as long as the memory of a frame. */
typedef struct toliman_ingest_event {
    uint32_t struct_size; /* in: sizeof(toliman_ingest_event) */
    int32_t event;        /* TOLIMAN_INGEST_EVENT_... */
    int32_t reason;       /* TOLIMAN_INGEST_REASON_... */
    int32_t has_key;      /* 1 for FRAME, and for DAMAGE if session, roi and frame_id are known; else 0 */
    const char *file; /* path of the side file; of EXTRA_BYTES, the file of pixels; of a batch, itself. Never NULL */
    int64_t line;     /* line of the side file, or frame of the batch, from 1; 0 for NOTHING and EXTRA_BYTES */
    const char *text; /* what is wrong, without file and line; "" for FRAME and NOTHING. Never NULL */
    int64_t stamp_ns; /* timestamp_ns as written, for FRAME, SHORT_FILE and PLACE_UNKNOWN; else 0 */
    double host_s;    /* host_time in s, for the same events; else 0 */
    int64_t offset;   /* byte of the file of pixels at which a FRAME begins by the lines before it, without the shift of
                       toliman_ingest_set_shift; 0 in a batch */
} toliman_ingest_event;
#define TOLIMAN_INGEST_EVENT_INIT TOLIMAN_INIT(toliman_ingest_event)

/* Reads the next event. Frames come in the order of their lines; a warning about a line precedes its frame.
 *   frame  becomes the frame of a FRAME event. For DAMAGE with has_key = 1: session, roi and frame_id, and unless the
 *          reason is BAD_LINE also camera_ns, dropped, rows and cols. All other members, and those of other events,
 *          are 0
 *   event  becomes the event
 * The struct_size of both must be set.
 *
 * Time: camera_ns is the middle of the exposure by the camera clock. It is timestamp_ns, plus half of exposure_s for
 * START, minus half of it for END, rounded to 1 ns. If the exposure is unknown, camera_ns is timestamp_ns.
 *
 * Restarts: after a reconnection of the camera frame_id begins again, and often its clock, while host_time continues.
 * restarts counts this, so that such frames have keys of their own (promise: restarted-counters-lose-no-frame). If the
 * clock begins again too, its times after the restart are moved to continue those before it as host_time does; one
 * clock table then holds for the session, within the delay of host_time. The same file gives the same restarts again.
 *
 * Intervals: those of on_target_s in the line, at most 64, or NULL if the line has none. A line with intervals is
 * reported as DAMAGE if options.exposure_s is 0.
 *
 * Memory: pixels, intervals, names and texts belong to the reader and stay valid during the next `buffers` - 1 calls of
 * next (promise: frames-outlive-their-buffers). With buffers = 1 they are valid until the next call.
 *
 * With GROWING, the first call and each call after NOTHING examine both files and read only what is new. A frame is
 * reported once its line, with the newline, and all its pixels are in the files (promise: growing-pairs-lose-no-frame).
 * After a file was replaced, truncated, or overwritten with the same size, next returns NOTHING and then all frames
 * from the first one (promise: replaced-pairs-start-again). A file overwritten by a longer one seems to have grown.
 * Without GROWING, the files are examined once, by the first call, and the last line needs no newline.
 *
 * Errors, after which next may be called again. It then examines the files again, and starts again with the first
 * frame if they have been replaced or truncated:
 *   - TOLIMAN_E_NOT_FOUND if a file cannot be read, or is truncated while it is read;
 *   - TOLIMAN_E_FORMAT if the file of pixels has twice or half the size of the frames of all lines, as with the other
 *     pixel type, and no line has been reported yet; with GROWING, if two examinations in a row find this;
 *   - TOLIMAN_E_FORMAT if a side file of n bytes has more than 1024 + n/120 lines. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_next(toliman_ingest *ingest, toliman_frame *frame,
                                                                  toliman_ingest_event *event) TOLIMAN_NOEXCEPT;

/* Finds a frame that is not at its place, because the file of pixels has lost or gained bytes before it: a part of a
 * frame without a line, or of a frame whose rest is lost. Such a frame is a misfit of a tracker (track.h).
 *   offset     of the frame's pixels in the file: that of its FRAME event
 *   reference  an undamaged frame of the same scene, shape and pixel type
 *   pixels     [rows][cols], receives the frame from where it looks most like the reference
 *   size       of pixels, in bytes
 *   shift      receives the bytes from the frame's place to there; 0 if it is not found elsewhere: pixels is unchanged
 * The size of the file, compared with that of the frames of all lines, tells whether bytes were lost or gained; with
 * GROWING it does not, and no frame is found, nor is one in a batch. The likeness is that of images: let the estimator
 * confirm the frame.
 * Errors: TOLIMAN_E_CAPACITY if size is too small; TOLIMAN_E_NOT_FOUND if the file cannot be read. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_find_frame(const toliman_ingest *ingest, int64_t offset,
                                                                        const toliman_frame *reference, void *pixels,
                                                                        size_t size, int64_t *shift) TOLIMAN_NOEXCEPT;

/* Sets the shift, in bytes, at which frames that were not reported yet are read, 0 at the beginning. No effect on a
 * file that has exactly the size of the frames of all lines. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_set_shift(toliman_ingest *ingest,
                                                                       int64_t shift) TOLIMAN_NOEXCEPT;

/* Declares that the files no longer grow. The following calls of next report what was found before, do not examine the
 * files again (only a first call does), and end with NOTHING. Lines without pixels are reported as DAMAGE, and pixels
 * without line as EXTRA_BYTES, if the files did not change between their last two examinations and not since then;
 * otherwise they may still be growing, and neither is reported. Therefore call next until it has returned NOTHING
 * twice, with a pause between both calls, then finish. A last line without newline is not reported. Cannot be undone;
 * no effect without GROWING. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_finish(toliman_ingest *ingest) TOLIMAN_NOEXCEPT;

/* Returns the version of netCDF, which reads batches ("4.9.0"); "" if the library was built without it. */
TOLIMAN_API const char *toliman_ingest_netcdf_version(void) TOLIMAN_NOEXCEPT;

/* Properties and counts of a reader. */
typedef struct toliman_ingest_info {
    uint32_t struct_size;               /* in: sizeof(toliman_ingest_info) */
    int32_t stamp;                      /* TOLIMAN_FRAME_STAMP_... */
    double exposure_s;                  /* as in the options */
    int64_t lines;                      /* lines of the side file read so far, since it was last replaced */
    int64_t frames;                     /* FRAME events */
    int64_t damaged;                    /* DAMAGE events */
    int64_t warnings;                   /* WARNING events */
    int64_t skipped;                    /* frames outside first_id to end_id or of another region */
    uint64_t bytes;                     /* size of the file of pixels when it was last examined; 0 before */
    const char *side_file, *pixel_file; /* paths, valid until the reader is destroyed; both that of a batch */
} toliman_ingest_info;
#define TOLIMAN_INGEST_INFO_INIT TOLIMAN_INIT(toliman_ingest_info)

/* Writes the properties and counts to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_get_info(const toliman_ingest *ingest,
                                                                      toliman_ingest_info *out) TOLIMAN_NOEXCEPT;

/* Reads a clock table: lines camera_ns,tai_ns (formats.md, "Clock table").
 *   clock  [capacity][2], pairs for toliman_track_clock
 *   count  becomes the number of pairs
 *   log    receives one warning if a rate differs from 1 by more than 1 %, for instance for columns in other units or
 *          in the wrong order, also if capacity is too small; may be NULL. user_data is passed to it
 * Errors: TOLIMAN_E_NOT_FOUND; TOLIMAN_E_FORMAT, with file and line, if the file is malformed or has no pair;
 * TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_clock(const char *path, int64_t *clock,
                                                                        size_t capacity, size_t *count,
                                                                        toliman_log_fn log,
                                                                        void *user_data) TOLIMAN_NOEXCEPT;

/* Time scales. TT = TAI + 32.184 s, GPS = TAI - 19 s. TDB differs from TT by less than 2 ms and is treated as TT. */
#define TOLIMAN_INGEST_SCALE_UTC 631
#define TOLIMAN_INGEST_SCALE_TAI 632
#define TOLIMAN_INGEST_SCALE_TT 633
#define TOLIMAN_INGEST_SCALE_TDB 634
#define TOLIMAN_INGEST_SCALE_GPS 635

/* Formats of a time in text. */
#define TOLIMAN_INGEST_FORMAT_ISO 641 /* 2028-03-01, 2028-03-01T12:00:00.5, 2028-061 12:00:00; see parse_time */
#define TOLIMAN_INGEST_FORMAT_MJD 642 /* Modified Julian Day, a decimal number ("61831.5") */
#define TOLIMAN_INGEST_FORMAT_JD 643  /* Julian Day, a decimal number ("2461832.0") */

/* Row of a table of leap seconds. */
typedef struct toliman_leap_second {
    uint32_t struct_size; /* sizeof(toliman_leap_second) */
    int32_t tai_utc_s;    /* TAI - UTC in s, from `mjd` on */
    int64_t mjd;          /* Modified Julian Day on which this difference begins, at 0 h UTC */
} toliman_leap_second;
#define TOLIMAN_LEAP_SECOND_INIT TOLIMAN_INIT(toliman_leap_second)

/* Reads a table of leap seconds.
 *   path     a leap-seconds.list of the IERS; NULL = the table of the ERFA library
 *   table    [capacity], with the struct_size of table[0] set
 *   count    becomes the number of rows
 *   expires  becomes the day (MJD) from which on leap seconds may be missing: the expiry of the file, or 1 January of
 *            the first year that ERFA calls dubious; may be NULL
 * A list of leap seconds is refused if it is damaged, truncated or not that of ERFA
 * (promise: leap-seconds-are-verified), with TOLIMAN_E_FORMAT: if the SHA-1 in its line #h is not that of its numbers,
 * if it has a date (#$) but no #h, and if it differs from the table of ERFA up to the last row or release of that.
 * Errors: TOLIMAN_E_NOT_FOUND, TOLIMAN_E_FORMAT with file and line, TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_leap_seconds(const char *path,
                                                                               toliman_leap_second *table,
                                                                               size_t capacity, size_t *count,
                                                                               int64_t *expires) TOLIMAN_NOEXCEPT;

/* Returns the latest day (MJD) of UTC that any function has converted on this thread, 0 for none. From the day
 * `expires` of toliman_ingest_read_leap_seconds on, leap seconds may be missing: a program compares both at its end,
 * and warns. */
TOLIMAN_API int64_t toliman_ingest_last_utc_day(void) TOLIMAN_NOEXCEPT;

/* Converts text to TAI nanoseconds since 1970-01-01T00:00:00 TAI.
 *   text    a time from 1958-01-01 to 2099-12-31 of its scale, in UTC from 1972-01-01 on. A date is YYYY-MM-DD or
 *           YYYY-DDD (day of the year), alone (0 h) or with T or one blank and hh:mm:ss[.s...]. In UTC the time may end
 *           with Z or an offset of 0, +00:00; another offset is refused. All readers of dates accept these forms; those
 *           of FITS headers, observer files and on-target windows refuse a date without time
 *   format  TOLIMAN_INGEST_FORMAT_...
 *   scale   TOLIMAN_INGEST_SCALE_... of the text
 *   table   [count] leap seconds for UTC; NULL if count is 0: those of ERFA. The first row is 10 s on MJD 41317
 *           (1972-01-01), each further row a later day and 1 s more or less
 * Conversions of times are exact (promise: dates-are-exact): a date is truncated to the nanosecond, a decimal day
 * rounded to the nearest one. A UTC day that ends with a leap second has 86,401 s, and so has its Julian Day. After the
 * last row of the table, TAI - UTC remains constant.
 * Errors: TOLIMAN_E_FORMAT if the text is not such a time, TOLIMAN_E_RANGE outside these years, TOLIMAN_E_ARGUMENT for
 * a wrong table, also if the scale is not UTC. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_parse_time(const char *text, int32_t format, int32_t scale,
                                                                        const toliman_leap_second *table, size_t count,
                                                                        int64_t *tai_ns) TOLIMAN_NOEXCEPT;

/* Reads a table of on-target windows: times in which the telescope points at the stars (formats.md, "On-target
 * windows").
 *   leap_seconds  [leap_second_count] leap seconds for UTC, as in toliman_ingest_parse_time
 *   intervals     [capacity][2], start and end of each window in TAI nanoseconds since 1970-01-01T00:00:00 TAI,
 *                 increasing. A window may begin where the one before it ends
 *   count         becomes the number of windows, at least 1
 * Errors: TOLIMAN_E_NOT_FOUND; TOLIMAN_E_FORMAT, with file and line, if the file is malformed or has no window;
 * TOLIMAN_E_CAPACITY if capacity is too small; TOLIMAN_E_ARGUMENT for a wrong table of leap seconds. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_read_on_target(const char *path,
                                                                            const toliman_leap_second *leap_seconds,
                                                                            size_t leap_second_count,
                                                                            int64_t *intervals, size_t capacity,
                                                                            size_t *count) TOLIMAN_NOEXCEPT;

/* Keywords of a FITS header that give the time of its first frame. Each is the text of the header, strings with or
 * without their quotes; NULL = the keyword is missing or has no value. */
typedef struct toliman_ingest_header {
    uint32_t struct_size; /* sizeof(toliman_ingest_header) */
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

/* Flags of toliman_ingest_header_time. */
#define TOLIMAN_INGEST_ASSUMED 1u /* TIMESYS or the length is missing: UTC or mid-exposure is assumed */
#define TOLIMAN_INGEST_EXPIRED 2u /* UTC on the day `expires` or later, whose leap seconds may not be known */

/* Time of a header. */
typedef struct toliman_ingest_header_time {
    uint32_t struct_size; /* in: sizeof(toliman_ingest_header_time) */
    uint32_t flags;       /* TOLIMAN_INGEST_ASSUMED, TOLIMAN_INGEST_EXPIRED */
    int64_t tai_ns;       /* middle of the first exposure, TAI nanoseconds since 1970-01-01T00:00:00 TAI */
    char rule[120];       /* keywords and scale in words, for messages: "MJD-OBS + EXPTIME/2 in TAI" */
    double exposure_s;    /* length of the exposure from start to end; 0 = unknown */
} toliman_ingest_header_time;
#define TOLIMAN_INGEST_HEADER_TIME_INIT TOLIMAN_INIT(toliman_ingest_header_time)

/* Reads the time of the first frame from the keywords of a FITS header (FITS Standard 4.0, section 9).
 *   Start    MJD-BEG, DATE-BEG, MJD-OBS or DATE-OBS; a DATE-... without time needs TIME-..., UTC-OBS or UT
 *   Middle   MJD-AVG or DATE-AVG. End: MJD-END or DATE-END
 *   Length   TELAPSE, otherwise XPOSURE, EXPTIME or EXPOSURE, otherwise from start to end
 * The middle is used if it is given, otherwise the start, otherwise the end; of several keywords, the one with finer
 * digits. Half of the length is added to a start. A start without length is taken as mid-exposure. All other times of a
 * header must agree with the result within half an exposure and their last digit
 * (promise: contradicting-headers-are-refused); only TELAPSE may exceed the other lengths, by pauses.
 *   table    [count] leap seconds for UTC, as in toliman_ingest_parse_time
 *   expires  day (MJD) from toliman_ingest_read_leap_seconds; ignored if count is 0
 *   time     becomes the time
 * Errors: TOLIMAN_E_NOT_FOUND if the header has none of these times; TOLIMAN_E_FORMAT and TOLIMAN_E_RANGE, with the
 * keyword, as toliman_ingest_parse_time, for keywords that contradict each other (both are named), for a date without
 * time, an unknown TIMESYS, a bad length, and a TREFPOS outside the Earth; TOLIMAN_E_ARGUMENT for a wrong table. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_ingest_read_header(const toliman_ingest_header *header, const toliman_leap_second *table, size_t count,
                           int64_t expires, toliman_ingest_header_time *time) TOLIMAN_NOEXCEPT;

/* Converts times[count], nanoseconds since 1970-01-01T00:00:00 of their scale, to TAI nanoseconds. In UTC every day
 * counts 86,400 s, as in POSIX and in NumPy's datetime64: a time within a leap second has the same number as the time
 * 1 s later, and is converted as the latter.
 *   scale          TOLIMAN_INGEST_SCALE_... of the times
 *   table          [rows] leap seconds, as in toliman_ingest_parse_time
 *   tai_ns         [count]; may be `times`, must not overlap it otherwise
 * Errors: TOLIMAN_E_RANGE outside the years of toliman_ingest_parse_time, naming the element; TOLIMAN_E_ARGUMENT for a
 * wrong table. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_ingest_convert_times(const int64_t *times, size_t count,
                                                                           int32_t scale,
                                                                           const toliman_leap_second *table,
                                                                           size_t rows,
                                                                           int64_t *tai_ns) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
