/* libtoliman, tracking: turns downlinked frames into a period, one frame at a time. Each frame counts once, in whatever
 * order, and however often, it arrives; one that was committed is not lost if the process is killed.
 *
 * Data flow (functions toliman_track_...)
 *
 *                 load_options -> create <- folder (ledger, setup, checkpoint)
 *                                    |
 *   frames[count] -> push -> toliman_track -> outcomes[count]; get_period -> period.h
 *   other folders -> merge ----------+
 *                                    +-> query_fit, get_info, get_rejected, get_options, get_clock;
 *                                    |   verdict_name, reason_name; records, sessions: track_records.h
 *                                    +-> commit, save -> folder
 *                                 destroy
 *
 * Frames may arrive in any order, repeatedly or damaged. A frame is identified by its key (session, frame id, region
 * of interest), because packet counters wrap and times repeat. Each frame is checked, measured by an estimator,
 * assigned a time, and added to a periodogram. Its verdict is one of:
 *
 *   accepted     valid, and the first valid frame with its key
 *   duplicate    valid, same key and same content (frame.h) as an earlier valid frame; ignored
 *   quarantined  valid, same key as an earlier valid frame but different content. Neither can be trusted: the value of
 *                the earlier frame is retracted exactly, and every later valid copy is quarantined, too
 *   misfit       valid and recorded, but not in the periodogram: its chi-square exceeds chi_limit of the folder,
 *                and |value| not value_limit. It may change with the median of the folder's frames
 *   outlier      valid, but not in the periodogram: |value| exceeds value_limit, or, after a change of the grid or
 *                clock table, the periodogram can no longer represent the time of a frame accepted earlier
 *   unreduced    valid and recorded, but not in the periodogram: the observer file does not cover its exposure (a
 *                rebuild with another file reduces it), or its on-target intervals are not known (it must be pushed to
 *                a new folder with them)
 *   rejected     damaged (see the reasons). Frames with its key keep their verdicts; an intact copy may still arrive
 *
 * The time of a frame is its camera time, converted to TAI by the clock table. TAI is counted in nanoseconds from the
 * epoch of that table; `toliman track` uses 1970-01-01, and so must a tracker with a system. Exposure and on-target
 * intervals do not change the time. No barycentric correction is applied: the light travel time to the barycentre
 * varies by up to +-8.3 minutes over a year.
 *
 * Reduction. Without a system, the value of a frame is the estimate. With a system and an observer (sky.h), it is, in
 * pixels,
 *
 *   value = separation_px / factor - geometric_arcsec / plate_scale_arcsec
 *
 * Factor and geometric separation are means over the on-target intervals (good-time intervals) of the frame, or,
 * without a list of these, over the exposure. An observer in orbit needs the list for exposures longer than 600 s. The
 * system and the plate scale are the fixed reference of a folder. The observer file may differ from run to run. The
 * value contains planets, the error of the reference orbit, and noise.
 *
 * The ledger keeps the measured separation and the intervals. A rebuild with `sky` reduces all frames again without
 * their pixels, for instance with a definitive observer file or a refitted system. The periodogram then has the bits of
 * a folder that had them from the start, with the same grid, clock table, plate scale and value_limit.
 *
 * The periodogram has the same bits for any order of arrival, if all values are computed with one instruction set.
 *
 * In a folder, each frame is recorded in a ledger (formats.md, "TLML"), the authoritative record. The folder also
 * holds the grid and clock table (setup), the names of sessions and regions (streams.txt), and the accumulators
 * (checkpoint), which are rebuilt from the ledger if necessary. A crash loses no committed frame.
 */
#ifndef TOLIMAN_TRACK_H
#define TOLIMAN_TRACK_H

#include <toliman/bank.h>
#include <toliman/cae.h>
#include <toliman/fit.h>
#include <toliman/frame.h>
#include <toliman/goodness.h>
#include <toliman/linear.h>
#include <toliman/period.h>
#include <toliman/sky.h>

TOLIMAN_BEGIN_DECLS

/* Tracker. Functions that take a const tracker may run on one tracker from several threads; all others need exclusive
 * use. */
typedef struct toliman_track toliman_track;

/* Verdicts, explained above. */
#define TOLIMAN_TRACK_VERDICT_ACCEPTED 501
#define TOLIMAN_TRACK_VERDICT_DUPLICATE 502
#define TOLIMAN_TRACK_VERDICT_QUARANTINED 503
#define TOLIMAN_TRACK_VERDICT_OUTLIER 504
#define TOLIMAN_TRACK_VERDICT_REJECTED 505
#define TOLIMAN_TRACK_VERDICT_MERGED 506    /* never an outcome: a record of counts (repeats, merged ledger) */
#define TOLIMAN_TRACK_VERDICT_UNREDUCED 507 /* */
#define TOLIMAN_TRACK_VERDICT_INTERVALS 508 /* never an outcome: on-target intervals of the next frame */
#define TOLIMAN_TRACK_VERDICT_MISFIT 509    /* */

/* Reasons for rejection, and why a frame is unreduced. */
#define TOLIMAN_TRACK_REASON_NONE 511
#define TOLIMAN_TRACK_REASON_SHAPE 512      /* number of rows or columns differs from the tracker's */
#define TOLIMAN_TRACK_REASON_OVER_RANGE 513 /* pixel above the bit depth */
#define TOLIMAN_TRACK_REASON_ZERO_RUN 514   /* run of zero pixels of at least zero_run_bytes (lost packet) */
#define TOLIMAN_TRACK_REASON_NOT_FINITE 515 /* pixel that is NaN or infinite */
/* Time that overflows in TAI, that the periodogram cannot represent, or outside the span of its trend. */
#define TOLIMAN_TRACK_REASON_CLOCK 516
#define TOLIMAN_TRACK_REASON_ESTIMATE 517 /* estimator failed, or gave a non-finite value or a sigma out of range */

#define TOLIMAN_TRACK_REASON_NO_ORBIT 518 /* unreduced: the observer file has no state at its time */
/* Unreduced: the observer is in orbit, and the exposure is unknown, or longer than 600 s without a list of on-target
 * intervals; or an interval is shorter than 1 ns or longer than 400 days. */
#define TOLIMAN_TRACK_REASON_NO_INTERVALS 519

/* Outcome of a pushed frame. */
typedef struct toliman_track_outcome {
    uint32_t struct_size; /* in: sizeof(toliman_track_outcome) */
    int32_t verdict;      /* TOLIMAN_TRACK_VERDICT_... */
    int32_t reason;       /* TOLIMAN_TRACK_REASON_... of a rejected or unreduced frame */
    int32_t reserved;
    int64_t row, col; /* first pixel over range, not finite, or completing a zero run; for SHAPE, the shape received */
    double pixel;     /* value of that pixel */
    double value;     /* accepted, outlier, misfit: reduced if the folder has a system; unreduced: the estimate */
    int64_t tai_ns;   /* these frames: time in TAI */
    /* These frames: goodness of fit (goodness.h); NaN and UNKNOWN without a model. */
    double chi_square, chi_square_sigma, largest_residual;
    int32_t goodness;    /* TOLIMAN_GOODNESS_... */
    uint32_t bad_pixels; /* pixels that were found damaged and left out of the estimate */
    double sigma;        /* these frames: standard deviation of the value; 0 for others */
} toliman_track_outcome;
#define TOLIMAN_TRACK_OUTCOME_INIT TOLIMAN_INIT(toliman_track_outcome)

/* Called on the thread of toliman_track_push for a misfit, before it is recorded. *other is a copy of *frame: its
 * pixels, rows, cols, stride and pixel may be changed, for example to those that toliman_ingest_find_frame finds; they
 * must stay valid until the push returns. Returns 1 to try *other, which is recorded in place of the frame unless it is
 * a misfit, too; 0 to record the frame. An exception and other numbers count as 0. */
typedef int32_t (*toliman_misfit_fn)(const toliman_frame *frame, const toliman_track_outcome *outcome,
                                     toliman_frame *other, void *user_data);

/* Flags of toliman_track_options. */
#define TOLIMAN_TRACK_READ_ONLY 1u /* opens the folder for reading, also while another tracker writes to it */
/* Rebuilds the accumulators from the ledger with the grid and clock table of these options. Frames rejected for their
 * time must be pushed again. With `sky`, all frames are reduced again, also those of a folder without a system. Frames
 * that its observer file does not cover keep their reduction if system and clock table are unchanged; otherwise they
 * become unreduced. The ledger is replaced: a tracker that merged the folder before counts its frames as repeated.
 * Another plate scale alone needs no `sky`. */
#define TOLIMAN_TRACK_REBUILD 2u
#define TOLIMAN_TRACK_SALVAGE 4u         /* flag of toliman_track_merge only: skip damaged records */
#define TOLIMAN_TRACK_ALLOW_ZERO_RUNS 8u /* rejects no frame for a run of zero pixels */

/* In the column `flags` of a ledger, flags TOLIMAN_BANK_... are multiplied by this factor. */
#define TOLIMAN_TRACK_BANK_FLAGS 256u

/* Durability of ledger records. A record is committed, and its frame acknowledged, once it has been fsync'ed (with
 * SYNC_NONE: once it has been written). toliman_track_info.committed counts committed records. The count of repeated
 * frames is written by commit, by save, and by the first push more than a second after it changed. */
#define TOLIMAN_TRACK_SYNC_GROUP 521 /* fsync after `group` records, and at a push if a record is older than 1 s */
#define TOLIMAN_TRACK_SYNC_FRAME 522 /* fsync after every record */
#define TOLIMAN_TRACK_SYNC_NONE 523  /* no fsync: a power failure may lose committed records */

/* Estimator of a tracker: one of cae, linear, fit and estimate, or none if no frame is pushed. It must outlive the
 * tracker, and a network must not be trained meanwhile. */
typedef struct toliman_track_estimator {
    const toliman_cae *cae;
    const toliman_linear *linear;
    /* Follows moving stars. The prediction of a frame is its time in the scene, (TAI - time_offset_ns) / 86400e9 days,
     * so that time 0 of the scene is TAI time_offset_ns. The value is displacement_px, its sigma separation_sigma_px;
     * the columns are those of values = "separation_px x_px y_px". The sigma of a frame may be 0.5 to 16 times that of
     * the scene's frame at time 0. A frame that does not converge is rejected with REASON_ESTIMATE. REBUILD with another
     * time_offset_ns does not change values recorded before. */
    const toliman_fit *fit;
    /* NULL, or the networks that estimate the separation. Requires `fit`, for which the bank must have been made
     * (otherwise TOLIMAN_E_MISMATCH). Each frame is encoded by toliman_bank_encode with the prediction described at
     * `fit`. The value is displacement_px, and sigma is sigma_px of toliman_bank_result; chi_square is that of the fit.
     * The column flags is TOLIMAN_FIT_... + TOLIMAN_TRACK_BANK_FLAGS * TOLIMAN_BANK_.... The columns are those of
     * values = "separation_px x_px y_px fit_separation_px": the separation of the networks, the shift of the scene's
     * centre, and the separation of the fit. The efficiency is sqrt(cov_fit_separation_px_fit_separation_px)/sigma.
     * Each network must be trained to an efficiency of at least 0.5 at its place (otherwise TOLIMAN_E_ARGUMENT). A
     * folder refuses another bank, as any other estimator. */
    const toliman_bank *bank;
    toliman_estimate_fn estimate;
    void *estimate_data;
    uint64_t id;      /* number that identifies `estimate`. If no estimator is given: the number of the estimator that
                         wrote the ledger. Ignored with cae, linear and fit, which have their own */
    double sigma;     /* standard deviation of a value; 0 = Cramer-Rao bound of cae or linear, half of that of fit;
                         required with `estimate` and without an estimator */
    char values[176]; /* list of names ("dx dy") of additional values of `estimate`: at most 7, of 1 to 24 characters
                         a-z 0-9 _; columns of a new ledger. "" with cae, linear and fit */
} toliman_track_estimator;

/* Frames of a tracker: rows x cols. From (crop_row, crop_col) on, blocks of bin x bin pixels are summed to the
 * image_rows x image_cols image that the estimator takes. Defaults (0): bin = 1; image_rows and image_cols = the shape
 * that cae, linear or fit takes, or, with `estimate`, as many blocks as fit into the frame; rows and cols = the smallest
 * frame that holds the image. */
typedef struct toliman_track_frames {
    int64_t rows, cols, crop_row, crop_col, bin, image_rows, image_cols;
    uint32_t bit_depth;      /* at most 32; a pixel of 2^bit_depth or more rejects the frame; 0 = no limit */
    uint32_t zero_run_bytes; /* a run of consecutive zero pixels of this many bytes rejects the frame; 0 = 4096 */
    /* Origin of the camera_ns of all frames: stamp and exposure_s of toliman_ingest_options. The tracker records both
     * in the setup file. In a reduction, exposure_s is the exposure of frames without their own. */
    int32_t stamp; /* TOLIMAN_FRAME_STAMP_..., 0 = that of the folder; in a new folder MIDDLE */
    uint32_t reserved;
    double exposure_s; /* length of an exposure, at most 1e9 s; 0 = that of the folder; in a new folder unknown */
} toliman_track_frames;

/* Periodogram of a tracker: frequencies f0 + k df, k < nf, in cycles per unit_ns nanoseconds of TAI. nf = 0: the grid of
 * the folder, with its time_offset_ns, unit_ns and flags.
 *
 * Nuisance functions are fitted with the mean at each frequency (period_nuisance.h). With TOLIMAN_PERIOD_FIXED_MEAN
 * there are none. */
typedef struct toliman_track_grid {
    double f0, df;
    int64_t nf;
    int64_t time_offset_ns; /* TAI of time 0 */
    double unit_ns;         /* 0 = 86400e9, days */
    uint32_t flags;         /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB */
    int32_t trend;          /* 1 to 8: a trend of this order; -1: none, the mean alone; 0 = the functions of the folder.
                               In a new folder, and in a rebuild with sky, 0 = with sky the errors of its orbit
                               (toliman_sky_set_columns), otherwise none */
    double trend_start, trend_end; /* span of the trend, in units of unit_ns since time_offset_ns. A frame outside is
                                      rejected with REASON_CLOCK. Both 0 = from -0.05/df to 0.15/df, twice the time span
                                      of the grid */
} toliman_track_grid;

/* Clock table of a tracker: pairs of camera nanoseconds and TAI nanoseconds, both increasing. Linear interpolation
 * between pairs and extrapolation beyond them; one pair is a constant difference; the pair (0, 0) means that camera time
 * is TAI. No pairs: the clock table of the folder, also with REBUILD; in a new folder the camera time is TAI. If the
 * setup file of the folder is lost, grid, clock table, stamp and system must be given. */
typedef struct toliman_track_clock {
    const int64_t *pairs; /* [count][2] */
    size_t count;
} toliman_track_clock;

/* Reduction of a tracker's values to the orbit of the binary. */
typedef struct toliman_track_reduction {
    /* System and observer, with all effects, or NULL. The tracker must have a value separation_px: with `fit`, or with
     * `estimate` and this name in `values`. To push frames to a folder with a system, give the same system, and an
     * observer in orbit if it had one (TOLIMAN_E_ARGUMENT if NULL, TOLIMAN_E_MISMATCH for another). To read or merge,
     * give NULL. Must outlive the tracker. */
    const toliman_sky *sky;
    double plate_scale_arcsec; /* arcsec per px, at most 1e6; 0 = that of the folder, or of the scene of `fit`.
                                  toliman_track_load_options: 0 = the folder has no system */
    double scale_sigma;        /* standard deviation of the relative error of the plate scale, in [0, 1); 0 = that of
                                  the folder; in a new folder no error */
} toliman_track_reduction;

/* Limits of a tracker. */
typedef struct toliman_track_limits {
    double value; /* a frame with |value| above it is an outlier; 0 = 10,000 sigma, with sky at least 0.25 px */
    /* Of the chi-square of a frame; frames above it are misfits.
     *   > 0  this number
     *   -1   4 times the median of all valid frames of the folder, misfits included, at least 2 and at most 100,
     *        rounded by up to 0.4 %: a model that is wrong by a chi-square of 10 is usable, and one of 1000 is not. The
     *        verdict of earlier frames changes with the median; it does not depend on the order of arrival
     *   0    that of the folder; in a new folder 2 if the scene of `fit` is that of a calibration, otherwise -1 */
    double chi_square;
    toliman_misfit_fn misfit; /* may be NULL */
    void *misfit_data;
} toliman_track_limits;

/* Ledger of a tracker. */
typedef struct toliman_track_ledger {
    int64_t capacity; /* largest number of frames, at most 2^28; 0 = 2^20. Memory: 3.2 MB + 24 bytes per frame */
    int32_t sync;     /* TOLIMAN_TRACK_SYNC_..., 0 = GROUP */
    uint32_t group;   /* records per fsync, 1 to 65536; 0 = 64 */
    /* NULL, or an existing folder: a new folder takes its clock table, system and plate scale, with nf = 0 also its
     * grid, and with stamp = 0 its stamp and exposure_s. For a merge. */
    const char *setup_folder;
} toliman_track_ledger;

/* Options of a tracker. */
typedef struct toliman_track_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_TRACK_... */
    const char *folder; /* folder of ledger, setup and checkpoint, created if missing. NULL = in memory, which takes
                           64 bytes more per frame and 8 per column */
    toliman_track_estimator estimator;
    toliman_track_frames frames;
    toliman_track_grid grid;
    toliman_track_clock clock;
    toliman_track_reduction reduction;
    toliman_track_limits limits;
    toliman_track_ledger ledger;
    uint32_t threads; /* threads that estimate; 0 = one per processor, but 1 with `estimate`, which then need not be
                         thread-safe. Results do not depend on the number */
    uint32_t reserved;
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    /* Receives a warning for each kind of damage that toliman_track_create repairs or ignores, during that call only:
     * a checkpoint that is damaged, missing or of another ledger; an incomplete record at the end of the ledger; lost
     * session names. May be NULL. */
    toliman_log_fn log;
    void *log_data;
} toliman_track_options;
#define TOLIMAN_TRACK_OPTIONS_INIT TOLIMAN_INIT(toliman_track_options)

/* Reads the options of a folder to *options, whose struct_size must be set, for toliman_track_create: folder (the
 * given pointer), id, values and sigma of the estimator, frames, grid, limits, plate_scale_arcsec and scale_sigma (nf = 0
 * and stamp = 0 if the setup file is lost), the flag TOLIMAN_TRACK_ALLOW_ZERO_RUNS, and a capacity of twice the number
 * of records, at least 2^20 and at most 2^28. Other members are set to their defaults. Errors:
 *   - TOLIMAN_E_NOT_FOUND, with the folder as the field of the error, if it does not exist, cannot be opened or has no
 *     ledger of frames: toliman_track_create may begin one in it. With a file as the field if that cannot be read;
 *   - TOLIMAN_E_FORMAT if the ledger is damaged, or is missing although other files of the folder exist. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_load_options(const char *folder, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Creates a tracker, or opens an existing folder and continues with its frames. For an existing folder, start from
 * toliman_track_load_options. Allocates all memory and locks the ledger until the tracker is destroyed. The caller
 * destroys *out. Errors:
 *   - TOLIMAN_E_MISMATCH if the folder has another estimator, other values, geometry or limits, another stamp or
 *     exposure_s, or, without REBUILD, another grid, clock table, system, plate scale or chi_limit, and for the bank of
 *     another fit;
 *   - TOLIMAN_E_STATE if another tracker writes to the folder;
 *   - TOLIMAN_E_LOST if the ledger has lost records. toliman_track_merge with SALVAGE recovers the others;
 *   - TOLIMAN_E_FORMAT if the ledger is damaged otherwise, is missing although other files of the folder exist, or is
 *     not a regular file;
 *   - TOLIMAN_E_CAPACITY if the folder holds more frames than capacity;
 *   - TOLIMAN_E_NOT_FOUND if a folder to be read does not exist; TOLIMAN_E_WRITE; TOLIMAN_E_INTERNAL if the system
 *     provides no random numbers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_create(const toliman_track_options *options,
                                                                   toliman_track **out) TOLIMAN_NOEXCEPT;

/* Destroys a tracker. NULL is allowed. Uncommitted records are lost, as in a crash. */
TOLIMAN_API void toliman_track_destroy(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Processes frames[count] in order and writes outcomes[count]. A rejected frame is an outcome, not an error. Pass
 * several frames per call to use several threads. On an error, *done frames have been processed and the next one has
 * not. Errors:
 *   - TOLIMAN_E_ARGUMENT if a frame is invalid; then no frame is processed;
 *   - TOLIMAN_E_CAPACITY if the number of frames, or of sessions and regions (65,536), is exhausted;
 *   - TOLIMAN_E_WRITE if the ledger cannot be written. The tracker then takes no more frames; open the folder again;
 *   - TOLIMAN_E_LOST if another program removed, renamed, replaced or changed the ledger. It is checked before each
 *     group of records is written; no more frames are acknowledged;
 *   - TOLIMAN_E_STATE without an estimator, with READ_ONLY, and while another thread queries the tracker's
 *     periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_push(toliman_track *track, const toliman_frame *frames,
                                                                 size_t count, toliman_track_outcome *outcomes,
                                                                 size_t *done) TOLIMAN_NOEXCEPT;

/* Writes all records and the count of repeated frames, and fsyncs them (except with SYNC_NONE). Every pushed frame is
 * then acknowledged. Errors as toliman_track_push. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_commit(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Commits with fsync, also with SYNC_NONE, and writes a checkpoint, so that the folder opens fast. After an error,
 * records may have been committed. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_save(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Adds the records of another folder, as if its frames had been pushed here, and commits. The other folder may be in
 * use. Shards may be merged in any order, and a folder may be merged again as it grows: only new records count. Grid
 * and clock table remain those of this tracker. The counts received, repeated and rejected become those of both
 * folders.
 *   flags  0, or TOLIMAN_TRACK_SALVAGE: skips damaged records. All others count as new arrivals, even if they were
 *          merged before; the periodogram still contains each frame once
 *   lost   may be NULL: number of damaged records that were skipped, plus records missing at the end of the ledger
 *          although its checkpoint counts them. For frames without any record, see the missing frame ids of
 *          toliman_track_get_streams
 * If several folders hold a frame, the value that was added first remains; networks on CPUs with different
 * instruction sets may differ by 1e-5 sigma.
 * Errors: as toliman_track_create and _push; TOLIMAN_E_MISMATCH for another estimator, other geometry or limits,
 * another stamp, exposure_s, system or plate scale, another clock table if the frames are reduced, or a column that
 * this ledger lacks; TOLIMAN_E_ARGUMENT for the tracker's own folder. After an error some records may have been added.
 * If the merge is repeated, they count again as received and as repeated or rejected, but not in the periodogram. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_merge(toliman_track *track, const char *folder,
                                                                  uint32_t flags, int64_t *lost) TOLIMAN_NOEXCEPT;

/* Counts and properties of a tracker. received = accepted + unreduced + outlier + misfit + quarantined +
 * repeated + rejected. received, repeated and rejected count arrivals: a frame that arrives again counts again, also
 * after the folder was reopened. The ledger holds all counts: a crash loses those of uncommitted frames only. */
typedef struct toliman_track_info {
    uint32_t struct_size; /* in: sizeof(toliman_track_info) */
    uint32_t flags;       /* TOLIMAN_TRACK_..., as given */
    int64_t received;     /* arrived frames, in this and earlier runs */
    int64_t accepted;     /* frames in the periodogram */
    int64_t outlier;
    int64_t quarantined; /* keys */
    int64_t repeated;    /* later arrivals of known keys, with the same or other content, here or in merged folders */
    int64_t rejected;    /* for any reason; see toliman_track_get_rejected */
    int64_t expected;    /* frame ids from the first to the last of each session and region */
    int64_t missing;     /* expected ids that are neither accepted nor unreduced, outlier, misfit nor quarantined */
    int64_t dropped;     /* frames dropped by the camera, as reported by all valid frames */
    int64_t sessions;    /* number of pairs of session and region */
    int64_t records;     /* records of the ledger; in memory, of accepted and unreduced frames and outliers */
    int64_t committed;   /* committed records; with READ_ONLY, records that the files show to be committed */
    int64_t capacity;
    uint64_t estimator_id;
    double sigma; /* that of the options: of values whose frame and estimator give none, and the least of others */
    double value_limit;
    int64_t unreduced;         /* frames that are not reduced */
    double plate_scale_arcsec; /* of the reduction; 0 = frames are not reduced */
    const char *system; /* of the reduction, JSON text that toliman_sky_create takes; NULL = frames are not reduced.
                           Valid until the tracker is destroyed */
    uint32_t elements;  /* bit j: the error of element j (sky.h) is a column of the periodogram */
    uint32_t reserved;
    int64_t misfit;    /* frames whose chi-square exceeds chi_limit */
    double chi_limit;  /* the limit in force */
    double chi_median; /* median chi-square of the valid frames, to 0.2 %; NaN without one */
} toliman_track_info;
#define TOLIMAN_TRACK_INFO_INIT TOLIMAN_INIT(toliman_track_info)

/* Writes the counts and properties of a tracker to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_info(const toliman_track *track,
                                                                     toliman_track_info *out) TOLIMAN_NOEXCEPT;

/* Writes the options in force to *options, whose struct_size must be set, with defaults resolved. folder and
 * clock.pairs point to memory of the tracker. Pointers to objects, callbacks and the allocator are NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_track_get_options(const toliman_track *track, toliman_track_options *options) TOLIMAN_NOEXCEPT;

/* Writes the number of frames rejected for one reason, TOLIMAN_TRACK_REASON_SHAPE or later, to *frames.
 * TOLIMAN_E_ARGUMENT for an unknown reason. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_rejected(const toliman_track *track, int32_t reason,
                                                                         int64_t *frames) TOLIMAN_NOEXCEPT;

/* Writes the clock table, pairs as in toliman_track_options, to clock[capacity][2]; *count becomes their number, 0
 * if camera time is TAI. TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_clock(const toliman_track *track, int64_t *clock,
                                                                      size_t capacity, size_t *count) TOLIMAN_NOEXCEPT;

/* Returns the tracker's periodogram in *out, for all queries of period.h. It is updated by every push and belongs to
 * the tracker, which destroys it. Queries during a push return TOLIMAN_E_STATE. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_get_period(const toliman_track *track,
                                                                       const toliman_period **out) TOLIMAN_NOEXCEPT;

/* Refines the highest peak with the accepted values, as toliman_period_query_fit: period, amplitude, phase at TAI
 * time_offset_ns, and standard errors. The result does not depend on the order of arrival. Reads all records and
 * temporarily takes 100 bytes per frame. Errors as toliman_period_query_fit; TOLIMAN_E_FORMAT if the ledger has been
 * damaged since it was opened. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_query_fit(const toliman_track *track,
                                                                      toliman_period_peak *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
