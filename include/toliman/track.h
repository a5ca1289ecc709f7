/* libtoliman, tracking: frames off the downlink -> the period, one frame at a time, losing nothing.
 *
 * Data flow (functions toliman_track_...)
 *
 *   options_init, load_options -> create <- folder (ledger, setup, checkpoint)
 *                                    |
 *   frames[count] -> push -> toliman_track -> outcomes[count]; get_period -> period.h
 *   other folders -> merge ----------+
 *                                    +-> query_fit, get_info, get_rejected, get_options, get_clock, get_streams,
 *                                    |   get_records, get_columns, get_column; verdict_name, reason_name
 *                                    +-> commit, save -> folder
 *                                 destroy
 *
 * Frames come in any order, some twice, some damaged. Each is known by (session, frame id, region of interest), since
 * packet counters wrap and times repeat. It is checked, estimated, given its time and pushed to a periodogram:
 *
 * accepted     good, and the first of its key
 * duplicate    the key and bytes of a frame that is in (pixels, time, frames dropped): nothing happens
 * quarantined  the key of a frame that is in, with other bytes: neither can be trusted, and what the first brought is
 *              taken back exactly; so it stays
 * outlier      good, but its value is beyond value_limit, or (after a change of grid or clock) its time has no place in
 *              the periodogram: known, not in the periodogram
 * rejected     damaged (see the reasons), whatever came before; a good copy may still come
 *
 * A frame's time is that of its clock, in TAI, the middle of the exposure if the clock tells that. Its exposure and
 * intervals do not change it. It is not brought to the barycentre (up to 8.3 minutes, a year's wave of its own).
 *
 * Whatever the order of arrival, the periodogram has the same bits. What cannot be seen: bits that flipped in a frame
 * of which there is no other copy, as the side file has no checksum.
 *
 * With a folder every frame's line goes to a ledger there (formats.md "TLML"), which is the truth; grid and clock
 * stand beside it, and the sums as a checkpoint, which are made anew from the ledger if need be. A crash loses no frame
 * that is committed.
 */
#ifndef TOLIMAN_TRACK_H
#define TOLIMAN_TRACK_H

#include <toliman/cae.h>
#include <toliman/image.h>
#include <toliman/linear.h>
#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Tracker. One thread at a time; const calls may run together. Since 0.1. */
typedef struct toliman_track toliman_track;

/* Verdicts, as above. */
#define TOLIMAN_TRACK_VERDICT_ACCEPTED 501
#define TOLIMAN_TRACK_VERDICT_DUPLICATE 502
#define TOLIMAN_TRACK_VERDICT_QUARANTINED 503
#define TOLIMAN_TRACK_VERDICT_OUTLIER 504
#define TOLIMAN_TRACK_VERDICT_REJECTED 505
#define TOLIMAN_TRACK_VERDICT_MERGED 506 /* of lines alone: counts of another ledger, or of repeats */

/* Returns the name of a verdict ("accepted"), "?" for an unknown one. Static text. Since 0.2. */
TOLIMAN_API const char *toliman_track_verdict_name(int32_t verdict) TOLIMAN_NOEXCEPT;

/* Why a frame is rejected. */
#define TOLIMAN_TRACK_REASON_NONE 511
#define TOLIMAN_TRACK_REASON_SHAPE 512      /* other rows or columns than the tracker's */
#define TOLIMAN_TRACK_REASON_OVER_RANGE 513 /* a pixel above the bit depth */
#define TOLIMAN_TRACK_REASON_ZERO_RUN 514   /* so many bytes of pixels of 0 in a row as a lost packet leaves */
#define TOLIMAN_TRACK_REASON_NOT_FINITE 515 /* a pixel that is NaN or infinite */
#define TOLIMAN_TRACK_REASON_CLOCK 516      /* a time without TAI, or too far off for the periodogram */
#define TOLIMAN_TRACK_REASON_ESTIMATE 517   /* the estimator failed, or gave no finite value or a sigma out of range */

/* A few words for a reason ("zero run"), "?" for an unknown one. Static text. Since 0.1. */
TOLIMAN_API const char *toliman_track_reason_name(int32_t reason) TOLIMAN_NOEXCEPT;

/* A frame as it arrived; the pixels are the caller's and need not outlive the call. Since 0.1. */
typedef struct toliman_frame {
    uint32_t struct_size; /* sizeof(toliman_frame) */
    int32_t pixel;        /* TOLIMAN_PIXEL_... of image.h, big-endian ones too */
    const char *session;  /* 1 to 64 of A-Z a-z 0-9 . _ - and not beginning with a dot, as is roi */
    const char *roi;
    int64_t frame_id;   /* any number, below 0 too */
    int64_t camera_ns;  /* the camera's clock */
    int64_t dropped;    /* frames that the camera dropped before this one, up to 65535; 0 where it does not say */
    const void *pixels; /* [rows][stride], aligned to a pixel */
    int64_t rows, cols;
    int64_t stride; /* pixels from row to row; 0 means cols */
    double sigma;   /* of this frame's value, 1 to 32 times the tracker's, which then is the least; 0: the tracker's */
    /* For estimators and the ledger; a frame that comes again must have the same. Intervals on the target are pairs of
     * start and end in s from the start of the exposure, rising and within it. */
    double exposure_s;              /* length of the exposure, up to 1e9; 0: not known */
    const double *intervals;        /* [interval_count][2]; may be NULL where interval_count is 0 */
    size_t interval_count;          /* up to 65536; 0: not known */
    int64_t window_row, window_col; /* row and column on the detector of the frame's first pixel, up to 2^31 */
} toliman_frame;
#define TOLIMAN_FRAME_INIT TOLIMAN_INIT(toliman_frame)

/* What became of a frame. Since 0.1. */
typedef struct toliman_track_outcome {
    uint32_t struct_size; /* in: sizeof(toliman_track_outcome), of the first at least */
    int32_t verdict;      /* TOLIMAN_TRACK_VERDICT_... */
    int32_t reason;       /* of rejected ones, TOLIMAN_TRACK_REASON_... */
    int32_t reserved;
    int64_t row, col;  /* of the pixel that is over range, not finite or completes a hole; of shape: the frame's */
    double pixel;      /* its value */
    double value;      /* of accepted ones and outliers: the estimate */
    int64_t tai_ns;    /* their time */
    double chi_square; /* of the same frames, per pixel, against the estimator's model; NaN where that has none */
} toliman_track_outcome;
#define TOLIMAN_TRACK_OUTCOME_INIT TOLIMAN_INIT(toliman_track_outcome)

/* What an estimator of the caller gets: an image, as crop and bin leave it, and what is known of it. Since 0.2. */
typedef struct toliman_estimate_input {
    uint32_t struct_size; /* sizeof(toliman_estimate_input) of the library */
    uint32_t reserved;
    const double *image; /* [rows][stride] */
    size_t rows, cols, stride;
    int64_t tai_ns;          /* the frame's time, by the tracker's clock */
    double variance_scale;   /* square of the frame's own sigma over the tracker's; 1 where the frame has none */
    double exposure_s;       /* as toliman_frame has it, like the intervals */
    const double *intervals; /* [interval_count][2] */
    size_t interval_count;
    int64_t window_row, window_col; /* row and column on the detector of the image's first pixel */
} toliman_estimate_input;
#define TOLIMAN_ESTIMATE_INPUT_INIT TOLIMAN_INIT(toliman_estimate_input)

/* What it gives. The library's arrays hold NaN, other members what is said behind the colon. Since 0.2. */
typedef struct toliman_estimate {
    uint32_t struct_size; /* sizeof(toliman_estimate) of the library */
    uint32_t flags;       /* bits of the estimator's own, kept in the column "flags"; none: 0 */
    double *values;       /* [value_count]: the first is the frame's value, the others are kept in their columns */
    size_t value_count;   /* 1, and 1 for each name of toliman_track_options.values */
    double *covariance;   /* [value_count][value_count], upper triangle; kept but for the first's variance, sigma^2 */
    double sigma;         /* of the first value, 1 to 32 times the tracker's; 0: the frame's or the tracker's */
    double chi_square;    /* of the image against the estimator's model, per pixel; NaN: not known */
} toliman_estimate;
#define TOLIMAN_ESTIMATE_INIT TOLIMAN_INIT(toliman_estimate)

/* Estimator of the caller: what *input says, and nothing else, decides what it gives. Nonzero, a first value that is
 * not finite or a sigma out of range rejects the frame. With several threads it is called from all of them at once.
 * Since 0.2. */
typedef int32_t (*toliman_estimate_fn)(const toliman_estimate_input *input, toliman_estimate *estimate,
                                       void *user_data);

/* Flags. READ_ONLY takes up the folder, beside its writer if need be; nothing can be pushed or saved. REBUILD makes the
 * sums anew from the ledger, on the grid and clock of these options; frames that were rejected for their time must come
 * again. SALVAGE is for toliman_track_merge alone. ALLOW_ZERO_RUNS rejects no frame for a run of zero pixels. */
#define TOLIMAN_TRACK_READ_ONLY 1u
#define TOLIMAN_TRACK_REBUILD 2u
#define TOLIMAN_TRACK_SALVAGE 4u
#define TOLIMAN_TRACK_ALLOW_ZERO_RUNS 8u

/* When a frame's line is brought to the disk, and so acknowledged. The count of repeated frames is brought there by
 * commit and save, and by the next push if it waits for a second. */
#define TOLIMAN_TRACK_SYNC_GROUP 521 /* every `group` lines, and lines that wait for a second at the next push */
#define TOLIMAN_TRACK_SYNC_FRAME 522 /* every line */
#define TOLIMAN_TRACK_SYNC_NONE 523  /* by the system: a power cut may lose what get_info calls committed */

/* What a tracker is. 0 is the default of every member. Since 0.1. */
typedef struct toliman_track_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_TRACK_... */
    const char *folder; /* of ledger, setup and checkpoint, made unless it is there; NULL: in memory, 64 bytes per
                           frame more and 8 per column */
    int64_t capacity;   /* frames at most, up to 2^28, 24 bytes each and 3.2 MB; 0: 2^20 */
    /* The estimator: one of the three, which must outlive the tracker and not be trained meanwhile; or none of them
     * where nothing is pushed. */
    const toliman_cae *cae;
    const toliman_linear *linear;
    toliman_estimate_fn estimate;
    void *estimate_data;
    uint64_t estimator_id; /* tells one `estimate` from another, and what lines were made by if there is none; of cae
                              and linear the library makes it */
    char values[176];      /* names of further values of `estimate`, separated by commas ("dx,dy"): up to 7, each of 1
                              to 24 of a-z 0-9 _; columns of a new ledger */
    double sigma;          /* of a value; 0: the Cramer-Rao bound that cae and linear know */
    double value_limit;    /* values further from 0 are outliers; 0: 10,000 sigma */
    /* Frames of rows x cols arrive; of these bin x bin pixels each are added up, from (crop_row, crop_col) on, to the
     * image that the estimator takes. 0: bin 1; the image that cae and linear know, or as much as there is
     * of the frame; frames as large as the image asks for. */
    int64_t rows, cols, crop_row, crop_col, bin, image_rows, image_cols;
    uint32_t bit_depth;      /* up to 32; a pixel of 2^bit_depth or more rejects the frame; 0: none does */
    uint32_t zero_run_bytes; /* pixels of 0 in a row that have so many bytes reject it; 0: 4096 */
    /* The periodogram: frequencies f0 + k df, k < nf, in cycles per unit_ns nanoseconds of TAI. nf = 0: the folder's,
     * with time_offset_ns, unit_ns and period_flags. */
    double f0, df;
    int64_t nf;
    int64_t time_offset_ns; /* TAI that is time 0 */
    double unit_ns;         /* 0: 86400e9, days */
    uint32_t period_flags;  /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB */
    uint32_t threads;       /* that estimate; 0: one per processor, but 1 with `estimate`, which need then not be safe
                               for threads. Never changes a bit */
    /* Camera nanoseconds -> TAI nanoseconds by straight lines: pairs [clock_points][2], both rising. One pair: a
     * constant difference, (0, 0) none. Beyond the ends the nearest line goes on. No pairs: the folder's clock, also
     * with REBUILD; of a new one the camera's time is TAI. If the folder's file of grid and clock is lost, both must be
     * given. */
    const int64_t *clock;
    size_t clock_points;
    int32_t sync;                       /* TOLIMAN_TRACK_SYNC_...; 0: GROUP */
    uint32_t group;                     /* lines, 1 to 65536; 0: 64 */
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
    /* Receives a warning for each damage that toliman_track_create finds and repairs or ignores, and only during that
     * call: a checkpoint that is damaged, missing or of another ledger, bytes behind the ledger's last whole record,
     * names of sessions that are lost. May be NULL. */
    toliman_log_fn log;
    void *log_data;
} toliman_track_options;
#define TOLIMAN_TRACK_OPTIONS_INIT TOLIMAN_INIT(toliman_track_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_track_options_init(toliman_track_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Fills *options, whose struct_size is set, with what a folder was made with, for toliman_track_create: folder (the
 * pointer given), estimator_id, values, sigma, limits (one of flags), geometry, grid, and a capacity for twice the
 * lines there are; nf = 0 if the file of grid and clock is lost. The rest are defaults. TOLIMAN_E_NOT_FOUND,
 * TOLIMAN_E_FORMAT. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_load_options(const char *folder, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Tracker, which takes up what the folder holds. All its memory is taken here. TOLIMAN_E_MISMATCH for a folder of
 * another estimator, other values, frames or limits, and, without REBUILD, another grid or clock; TOLIMAN_E_STATE if
 * another tracker is writing to it; TOLIMAN_E_LOST for a ledger that has lost lines, which SALVAGE of
 * toliman_track_merge leaves out; TOLIMAN_E_FORMAT for one that is damaged otherwise, that is missing though other
 * files of the folder are there, or that is no regular file; TOLIMAN_E_CAPACITY if it holds more frames;
 * TOLIMAN_E_NOT_FOUND if there is nothing to read; TOLIMAN_E_WRITE; TOLIMAN_E_INTERNAL if the system has no random
 * numbers to give. The ledger itself is locked until the tracker is destroyed. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_create(const toliman_track_options *options,
                                                                   toliman_track **out) TOLIMAN_NOEXCEPT;

/* Ends a tracker; NULL is allowed. Lines that are not committed are dropped, as by a crash. Since 0.1. */
TOLIMAN_API void toliman_track_destroy(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Takes frames[count] and says what became of each in outcomes[count]. On an error *done frames are in, the next is
 * not: TOLIMAN_E_ARGUMENT for an impossible frame, of which none of all is then taken; TOLIMAN_E_CAPACITY for a frame,
 * or a session and region (65,536), too many; TOLIMAN_E_WRITE where the ledger cannot be written: nothing more is taken
 * then until the folder is opened anew; TOLIMAN_E_LOST, before a group of lines is written, if the ledger was
 * removed, renamed, replaced or changed by another program: nothing more is acknowledged then; TOLIMAN_E_STATE without
 * an estimator and in READ_ONLY. Rejected frames are no error. Several frames at once are needed for several threads.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_push(toliman_track *track, const toliman_frame *frames,
                                                                 size_t count, toliman_track_outcome *outcomes,
                                                                 size_t *done) TOLIMAN_NOEXCEPT;

/* Brings every line and the count of repeated frames to the disk: all frames that were pushed are then acknowledged.
 * Errors as of push. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_commit(toliman_track *track) TOLIMAN_NOEXCEPT;

/* The same and a checkpoint, so that taking up is quick. After an error lines may be on the disk. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_save(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Takes the lines of another folder, also of one that is being written to, as if its frames had been pushed here, in
 * whatever shards and order, and commits. A folder may be merged again as it grows: only what came since counts. The
 * grid and clock are this one's. Of a frame that several folders have the value that came first stays; networks on
 * machines of unlike instruction sets may give values that differ by 1e-5 sigma. received, repeated and rejected become
 * those of both, also of frames that the other folder merged from a third. With flags = TOLIMAN_TRACK_SALVAGE lines of
 * a damaged ledger are left out, and all others count as new; else flags = 0. *lost (may be NULL) becomes how many were
 * left out, and how many more the checkpoint counts. Frames of which no line is left at all are not among them:
 * toliman_track_get_streams tells how many frame ids are missing.
 * TOLIMAN_E_MISMATCH for another estimator, other frames or limits, or a column that this ledger does not have;
 * TOLIMAN_E_ARGUMENT for the tracker's own folder;
 * errors as of create and push, after which some lines may be in, and count again when it is merged again. Since 0.1.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_merge(toliman_track *track, const char *folder,
                                                                  uint32_t flags, int64_t *lost) TOLIMAN_NOEXCEPT;

/* A line of the ledger: a frame as it arrived, and what it is by now; or one of the verdict
 * TOLIMAN_TRACK_VERDICT_MERGED. Since 0.1. */
typedef struct toliman_track_record {
    uint32_t struct_size; /* sizeof(toliman_track_record), of the first at least */
    int32_t verdict;      /* TOLIMAN_TRACK_VERDICT_...; of a frame that was denied later, quarantined */
    int32_t reason;       /* of rejected ones, TOLIMAN_TRACK_REASON_... */
    uint32_t content;     /* CRC32 of the frame */
    uint64_t stream;      /* FNV-1a of session and region */
    int64_t frame_id;
    int64_t camera_ns, tai_ns; /* by the tracker's clock */
    int64_t dropped;
    double value, sigma; /* 0 and the tracker's where there was none */
} toliman_track_record;
#define TOLIMAN_TRACK_RECORD_INIT TOLIMAN_INIT(toliman_track_record)

/* Lines from number `first` on, as many as there are, up to count, in the order of arrival; *done tells how many. A
 * duplicate has none. Without a folder there are lines of frames alone that came as good ones. The last values are
 * those from (lines of toliman_track_get_info) - count on. TOLIMAN_E_FORMAT if the ledger was damaged since: some lines
 * may then be written. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_records(const toliman_track *track, int64_t first,
                                                                        size_t count, toliman_track_record *records,
                                                                        size_t *done) TOLIMAN_NOEXCEPT;

/* Types of a column. */
#define TOLIMAN_TRACK_COLUMN_F64 531
#define TOLIMAN_TRACK_COLUMN_I64 532

/* A column of the ledger, which lines have beside the members of toliman_track_record. Every ledger of this version has
 * chi_square and flags as estimates have them; exposure_s, window_row and window_col as frames have them; shift_s, the
 * mean time of a frame's intervals minus the middle of its exposure, 0 without intervals. Then come the names of
 * toliman_track_options.values, and cov_A_B, the covariance of the values A and B, of which the first is called value
 * and cov_A_A is a variance. Since 0.2. */
typedef struct toliman_track_column {
    uint32_t struct_size; /* sizeof(toliman_track_column), of the first at least */
    int32_t type;         /* TOLIMAN_TRACK_COLUMN_... */
    char name[64];
} toliman_track_column;
#define TOLIMAN_TRACK_COLUMN_INIT TOLIMAN_INIT(toliman_track_column)

/* Columns to columns[capacity], in the order of the ledger; *count is how many there are. columns may be NULL where
 * capacity is 0: to ask for the number. TOLIMAN_E_CAPACITY for too little capacity. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_columns(const toliman_track *track,
                                                                        toliman_track_column *columns, size_t capacity,
                                                                        size_t *count) TOLIMAN_NOEXCEPT;

/* Numbers of a column, of the lines that toliman_track_get_records gives for the same `first` and count; NaN where a
 * line has none, 0 in columns of whole numbers. Those beyond 2^53 are rounded. TOLIMAN_E_NOT_FOUND for a name that no
 * column has; other errors as of get_records. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_column(const toliman_track *track, const char *name,
                                                                       int64_t first, size_t count, double *values,
                                                                       size_t *done) TOLIMAN_NOEXCEPT;

/* Counts. received = accepted + outlier + quarantined + repeated + all rejected. received, repeated and rejected count
 * arrivals: a frame that is pushed again counts again, also after the folder was opened anew. All counts are in the
 * ledger: a crash loses those of what was not committed, a lost checkpoint none. Since 0.1. */
typedef struct toliman_track_info {
    uint32_t struct_size; /* in: sizeof(toliman_track_info) */
    uint32_t flags;       /* TOLIMAN_TRACK_..., as given */
    int64_t received;     /* frames, by this or earlier runs */
    int64_t accepted;     /* in the periodogram now */
    int64_t outlier;
    int64_t quarantined; /* keys */
    int64_t repeated;    /* later arrivals of keys that are known, same or other bytes; here or in folders that were
                            merged */
    int64_t rejected;    /* for all reasons; toliman_track_get_rejected has those for one */
    int64_t expected;    /* frame ids from the first to the last of each session and region */
    int64_t missing;     /* of these, ids that are neither accepted nor outlier nor quarantined */
    int64_t dropped;     /* by the camera, as accepted frames and outliers tell */
    int64_t sessions;    /* and regions */
    int64_t records;     /* of the ledger; in memory, frames that came as good ones */
    int64_t committed;   /* lines that are acknowledged; of READ_ONLY those that the files tell to be */
    int64_t capacity;
    uint64_t estimator_id;
    double sigma; /* of a value */
    double value_limit;
} toliman_track_info;
#define TOLIMAN_TRACK_INFO_INIT TOLIMAN_INIT(toliman_track_info)

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_info(const toliman_track *track,
                                                                     toliman_track_info *out) TOLIMAN_NOEXCEPT;

/* Fills *options, whose struct_size is set, with what is in force, the defaults by their values: folder and clock,
 * whose memory is the tracker's, estimator_id, values, grid and all else but cae, linear, estimate, allocator and log,
 * which are NULL. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_get_options(const toliman_track *track, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Frames rejected for one reason, TOLIMAN_TRACK_REASON_SHAPE or a later one: *frames of info's rejected.
 * TOLIMAN_E_ARGUMENT for a reason that toliman_track_reason_name does not know. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_rejected(const toliman_track *track, int32_t reason,
                                                                         int64_t *frames) TOLIMAN_NOEXCEPT;

/* A session and region, by its names, which are empty where they are not known: without a folder, or if its line of
 * streams.txt was lost and no frame of it came since. Since 0.1. */
typedef struct toliman_track_stream {
    uint32_t struct_size; /* sizeof(toliman_track_stream), of the first at least */
    uint32_t reserved;
    uint64_t stream;           /* FNV-1a of both, as in toliman_track_record */
    int64_t first_id, last_id; /* frame ids */
    int64_t frames;            /* keys: those of accepted frames, outliers and quarantined ones */
    int64_t missing;           /* ids from the first to the last that are none of these */
    char session[72], roi[72];
} toliman_track_stream;
#define TOLIMAN_TRACK_STREAM_INIT TOLIMAN_INIT(toliman_track_stream)

/* Sessions and regions, sorted by name, to streams[capacity]; *count is how many there are. streams may be NULL where
 * capacity is 0: to ask for the number. TOLIMAN_E_CAPACITY for too little capacity. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_streams(const toliman_track *track,
                                                                        toliman_track_stream *streams, size_t capacity,
                                                                        size_t *count) TOLIMAN_NOEXCEPT;

/* The clock: its pairs to clock[capacity][2], as toliman_track_options has them, none where the camera's time is TAI;
 * *points is how many there are. clock may be NULL where capacity is 0: to ask for the number. TOLIMAN_E_CAPACITY for
 * too little capacity. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_clock(const toliman_track *track, int64_t *clock,
                                                                      size_t capacity, size_t *points) TOLIMAN_NOEXCEPT;

/* The tracker's own periodogram, for all queries of period.h; it follows every push and ends with the tracker.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_period(const toliman_track *track,
                                                                       const toliman_period **out) TOLIMAN_NOEXCEPT;

/* The highest peak refined against the values themselves, as toliman_period_query_fit on what is in the periodogram by
 * now, whatever order it came in: period, amplitude, phase at TAI time_offset_ns and their standard errors. Reads all
 * lines and takes 100 bytes a frame meanwhile. Errors as of that, and TOLIMAN_E_FORMAT if the ledger was damaged since.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_query_fit(const toliman_track *track,
                                                                      toliman_period_peak *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
