/* libtoliman, tracking: options of a tracker.
 *
 * Data flow
 *
 *   options: estimator, frames, grid, clock, reduction, limits, ledger -> toliman_track_create (track.h)
 *   folder -> toliman_track_load_options -> options
 */
#ifndef TOLIMAN_TRACK_OPTIONS_H
#define TOLIMAN_TRACK_OPTIONS_H

#include <toliman/bank.h>
#include <toliman/cae.h>
#include <toliman/fit.h>
#include <toliman/linear.h>
#include <toliman/period.h>
#include <toliman/sky.h>
#include <toliman/track_outcome.h>

TOLIMAN_BEGIN_DECLS

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

/* Durability of ledger records. A frame is acknowledged once its record has been fsync'ed, and survives power cuts
 * (promise: acknowledged-frames-survive-power-cuts); with SYNC_NONE once it has been written.
 * toliman_track_info.committed counts committed records. The count of repeated frames is written by commit, by save,
 * and by the first push more than a second after it changed. */
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
     * the scene's frame at time 0. A frame that does not converge is rejected with REASON_ESTIMATE. REBUILD with
     * another time_offset_ns does not change values recorded before. */
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
    uint64_t id; /* number that identifies `estimate`. If no estimator is given: the number of the estimator that
                         wrote the ledger. Ignored with cae, linear and fit, which have their own */
    double
        sigma; /* standard deviation of a value, in [1e-90, 1e90]; 0 = Cramer-Rao bound of cae or linear, half of that of fit;
                         required with `estimate` and without an estimator */
    char values[176]; /* list of names ("dx dy") of additional values of `estimate`: at most 7, of 1 to 24 characters
                         a-z 0-9 _; columns of a new ledger. "" with cae, linear and fit */
} toliman_track_estimator;

/* Frames of a tracker: rows x cols. From (crop_row, crop_col) on, blocks of bin x bin pixels are summed to the
 * image_rows x image_cols image that the estimator takes. Defaults (0): bin = 1; image_rows and image_cols = the shape
 * that cae, linear or fit takes, or, with `estimate`, as many blocks as fit into the frame; rows and cols = the
 * smallest frame that holds the image. */
typedef struct toliman_track_frames {
    int64_t rows, cols, crop_row, crop_col; /* in [0, 65536] */
    int64_t bin;                            /* in [1, 65536]; 0 = 1 */
    int64_t image_rows, image_cols;         /* in [0, 65536] */
    uint32_t bit_depth;      /* in [0, 32]: a pixel of 2^bit_depth or more rejects the frame; 0 = no limit */
    uint32_t zero_run_bytes; /* a run of consecutive zero pixels of this many bytes rejects the frame; 0 = 4096 */
    /* Origin of the camera_ns of all frames: stamp and exposure_s of toliman_ingest_options. The tracker records both
     * in the setup file. In a reduction, exposure_s is the exposure of frames without their own. */
    int32_t stamp; /* TOLIMAN_FRAME_STAMP_..., 0 = that of the folder; in a new folder MIDDLE */
    uint32_t reserved;
    double exposure_s; /* length of an exposure, in (0, 1e9] s; 0 = that of the folder; in a new folder unknown */
} toliman_track_frames;

/* Periodogram of a tracker: frequencies f0 + k df, k < nf, in cycles per unit_ns nanoseconds of TAI. nf = 0: the grid
 * of the folder, with its time_offset_ns, unit_ns and flags.
 *
 * Nuisance functions are fitted with the mean at each frequency (period_nuisance.h). With TOLIMAN_PERIOD_FIXED_MEAN
 * there are none. */
typedef struct toliman_track_grid {
    double f0, df;
    int64_t nf;
    int64_t time_offset_ns; /* TAI of time 0 */
    double unit_ns;         /* in [1, 1e30]; 0 = 86400e9, days */
    uint32_t flags;         /* TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB */
    int32_t trend; /* in [-1, 8]: a trend of this order; -1: none, the mean alone; 0 = the functions of the folder.
                               In a new folder, and in a rebuild with sky, 0 = with sky the errors of its orbit
                               (toliman_sky_set_columns), otherwise none */
    double trend_start, trend_end; /* span of the trend, in units of unit_ns since time_offset_ns. A frame outside is
                                      rejected with REASON_CLOCK. Both 0 = from -0.05/df to 0.15/df, twice the time span
                                      of the grid */
} toliman_track_grid;

/* Clock table of a tracker: pairs of camera nanoseconds and TAI nanoseconds, both increasing. Linear interpolation
 * between pairs and extrapolation beyond them; one pair is a constant difference; the pair (0, 0) means that camera
 * time is TAI. No pairs: the clock table of the folder, also with REBUILD; in a new folder the camera time is TAI. If
 * the setup file of the folder is lost, grid, clock table, stamp and system must be given. */
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
    double plate_scale_arcsec; /* arcsec per px, in (0, 1e6]; 0 = that of the folder, or of the scene of `fit`.
                                  toliman_track_load_options: 0 = the folder has no system */
    double scale_sigma;        /* standard deviation of the relative error of the plate scale, in [0, 1); 0 = that of
                                  the folder; in a new folder no error */
} toliman_track_reduction;

/* Limits of a tracker. */
typedef struct toliman_track_limits {
    double
        value; /* a frame with |value| above it is an outlier, in [1e-90, 1e90]; 0 = 10000 sigma, with sky at least 0.25 px */
    /* Of the chi-square of a frame; frames above it are misfits.
     *   > 0  this number
     *   -1   4 times the median of all valid frames of the folder, misfits included, at least 2 and at most 100,
     *        rounded by up to 0.4 %: a model that is wrong by a chi-square of 10 is usable, and one of 1000 is not.
     *        Verdicts follow the median, whatever the order of arrival (promise: misfits-ignore-arrival-order)
     *   0    that of the folder; in a new folder 2 if the scene of `fit` is that of a calibration, otherwise -1 */
    double chi_square;
    toliman_misfit_fn misfit; /* may be NULL */
    void *misfit_data;
} toliman_track_limits;

/* Ledger of a tracker. */
typedef struct toliman_track_ledger {
    int64_t capacity; /* largest number of frames, in [1, 2^28]; 0 = 2^20. Memory: 3.2 MB + 24 bytes per frame */
    int32_t sync;     /* TOLIMAN_TRACK_SYNC_..., 0 = GROUP */
    uint32_t group;   /* records per fsync, in [1, 65536]; 0 = 64 */
    /* NULL, or an existing folder: a new folder takes its clock table, system and plate scale, with nf = 0 also its
     * grid, and with stamp = 0 its stamp and exposure_s. For a merge. */
    const char *setup_folder;
} toliman_track_ledger;

/* Options of a tracker. */
typedef struct toliman_track_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_TRACK_READ_ONLY, _REBUILD, _ALLOW_ZERO_RUNS */
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
                         thread-safe */
    uint32_t reserved;
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    /* Receives one warning per kind of damage that toliman_track_create repairs or ignores
     * (promise: damage-is-told-once):
     * a checkpoint that is damaged, missing or of another ledger; an incomplete record at the end of the ledger; lost
     * session names. May be NULL. */
    toliman_log_fn log;
    void *log_data;
} toliman_track_options;
#define TOLIMAN_TRACK_OPTIONS_INIT TOLIMAN_INIT(toliman_track_options)

TOLIMAN_END_DECLS

#endif
