/* libtoliman, tracking: options of a tracker.
 *
 * Data flow
 *
 *   options, or folder -> toliman_track_load_options -> options -> toliman_track_create (track.h) */
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

#define TOLIMAN_TRACK_READ_ONLY 1u /* also while another tracker writes to the folder */
/* Rebuilds the accumulators from the ledger with the grid and clock table of these options. With `sky`, all frames are
 * reduced again: those that its observer file does not cover become unreduced, unless system and clock table are
 * unchanged. Another plate scale alone needs no `sky`. Frames rejected for their time must be pushed again. A tracker
 * that merged the folder before counts its frames as repeated. */
#define TOLIMAN_TRACK_REBUILD 2u
#define TOLIMAN_TRACK_SALVAGE 4u         /* of toliman_track_merge: skips damaged records */
#define TOLIMAN_TRACK_ALLOW_ZERO_RUNS 8u /* rejects no frame for zero pixels */

/* The column `flags` of a bank is TOLIMAN_FIT_... + TOLIMAN_TRACK_BANK_FLAGS * TOLIMAN_BANK_.... */
#define TOLIMAN_TRACK_BANK_FLAGS 256u

/* Durability of records. A frame is acknowledged once its record has been fsync'ed, and survives power cuts
 * (promise: acknowledged-frames-survive-power-cuts); with SYNC_NONE once it has been written. The count of repeated
 * frames is written by commit, save, and a push over a second after it changed. */
#define TOLIMAN_TRACK_SYNC_GROUP 521 /* fsync after `group` records, and at a push 1 s after a record */
#define TOLIMAN_TRACK_SYNC_FRAME 522
#define TOLIMAN_TRACK_SYNC_NONE 523 /* a power failure may lose committed records */

/* Estimator: cae, linear, fit or estimate; none if no frame is pushed. It must outlive the tracker; do not train its
 * network meanwhile. */
typedef struct toliman_track_estimator {
    const toliman_cae *cae;
    const toliman_linear *linear;
    /* Follows moving stars; time 0 of the scene is TAI time_offset_ns. Value: displacement_px; sigma:
     * separation_sigma_px, 0.5 to 16 times that of the scene's frame at time 0; columns: "separation_px x_px y_px".
     * Without convergence, a frame is rejected. Another time_offset_ns in a rebuild keeps recorded values. */
    const toliman_fit *fit;
    /* NULL, or networks for `fit`, each trained to an efficiency of at least 0.5 (otherwise TOLIMAN_E_ARGUMENT). Value
     * and sigma: of toliman_bank_result; chi_square: of the fit; flags: TOLIMAN_FIT_... + TOLIMAN_TRACK_BANK_FLAGS *
     * TOLIMAN_BANK_...; columns: "separation_px x_px y_px fit_separation_px", the last of the fit. The efficiency is
     * sqrt(cov_fit_separation_px_fit_separation_px)/sigma. */
    const toliman_bank *bank;
    toliman_estimate_fn estimate;
    void *estimate_data;
    uint64_t id;      /* of `estimate`; without an estimator: of the one that wrote the ledger */
    double sigma;     /* of a value, in [1e-90, 1e90]; 0 = Cramer-Rao bound of cae or linear, half of that of fit;
                         required with `estimate` and without an estimator */
    char values[176]; /* list of up to 7 further values of `estimate`, names of 1 to 24 characters a-z 0-9 _: columns
                         of a new ledger */
} toliman_track_estimator;

/* Frames: rows x cols. From (crop_row, crop_col) on, blocks of bin x bin pixels are summed to the image of the
 * estimator. Defaults (0): the image of cae, linear or fit, or, with `estimate`, as many blocks as fit; the smallest
 * frame that holds the image. */
typedef struct toliman_track_frames {
    int64_t rows, cols, crop_row, crop_col; /* in [0, 65536] */
    int64_t bin;                            /* in [1, 65536]; 0 = 1 */
    int64_t image_rows, image_cols;         /* in [0, 65536] */
    uint32_t bit_depth;                     /* in [0, 32]: pixels of 2^bit_depth or more reject the frame; 0 = no
                                               limit */
    uint32_t zero_run_bytes;                /* as many bytes of zero pixels in a row reject the frame; 0 = 4096 */
    /* Origin of camera_ns, as in toliman_ingest_options; in the setup file. */
    int32_t stamp; /* TOLIMAN_FRAME_STAMP_..., 0 = that of the folder; in a new folder MIDDLE */
    uint32_t reserved;
    double exposure_s; /* of frames without their own, in (0, 1e9] s; 0 = that of the folder; in a new folder unknown */
} toliman_track_frames;

/* Periodogram: frequencies f0 + k df, k < nf, per unit_ns of TAI. nf = 0: the grid of the folder, with its
 * time_offset_ns, unit_ns and flags. */
typedef struct toliman_track_grid {
    double f0, df;
    int64_t nf;
    int64_t time_offset_ns; /* TAI of time 0 */
    double unit_ns;         /* in [1, 1e30]; 0 = 86400e9, days */
    uint32_t flags;         /* TOLIMAN_PERIOD_FIXED_MEAN, _DOUBLE_LIMB */
    /* in [-1, 8]: order of a trend (period_nuisance.h); -1: none; 0 = the functions of the folder. In a new folder, and
     * in a rebuild with sky, 0 = with sky the errors of its orbit (toliman_sky_set_columns), otherwise none. None with
     * TOLIMAN_PERIOD_FIXED_MEAN. */
    int32_t trend;
    /* Span of the trend, in unit_ns since time_offset_ns; frames outside are rejected (REASON_CLOCK). Both 0 = from
     * -0.05/df to 0.15/df. */
    double trend_start, trend_end;
} toliman_track_grid;

/* Clock table: camera and TAI nanoseconds, both increasing, linear between and beyond; one pair is a constant
 * difference. No pairs: those of the folder, also with REBUILD; in a new folder camera time is TAI, (0, 0). If the
 * setup file is lost, grid, clock table, stamp and system must be given. */
typedef struct toliman_track_clock {
    const int64_t *pairs; /* [count][2] */
    size_t count;
} toliman_track_clock;

/* Reduction to the orbit of the binary. */
typedef struct toliman_track_reduction {
    /* System and observer, with all effects, or NULL; must outlive the tracker. Needs a value separation_px: `fit`, or
     * `estimate` with this name in `values`. NULL to read or merge; to push frames to a folder with a system, the same
     * one (else TOLIMAN_E_MISMATCH), with an observer in orbit if it had one. */
    const toliman_sky *sky;
    double plate_scale_arcsec; /* in (0, 1e6]; 0 = that of the folder, or of the scene of `fit` */
    double scale_sigma;        /* relative error of the plate scale, in [0, 1); 0 = that of the folder; in a new
                                  folder no error */
} toliman_track_reduction;

/* Limits of a tracker. */
typedef struct toliman_track_limits {
    double value; /* outliers exceed it in magnitude, in [1e-90, 1e90]; 0 = 10000 sigma, with sky at least 0.25 px */
    /* The chi-square of a misfit exceeds it.
     *   > 0  this number
     *   -1   4 times the median of the valid frames of the folder, 2 to 100. Verdicts follow the median, whatever the
     *        order of arrival (promise: misfits-ignore-arrival-order)
     *   0    that of the folder; in a new folder 2 if the scene of `fit` is that of a calibration, otherwise -1 */
    double chi_square;
    toliman_misfit_fn misfit;
    void *misfit_data;
} toliman_track_limits;

/* Ledger of a tracker. */
typedef struct toliman_track_ledger {
    int64_t capacity; /* frames, in [1, 2^28]; 0 = 2^20. Memory: 3.2 MB + 24 bytes each */
    int32_t sync;     /* TOLIMAN_TRACK_SYNC_..., 0 = GROUP */
    uint32_t group;   /* records per fsync, in [1, 65536]; 0 = 64 */
    /* Folder for a merge, or NULL: a new folder takes its clock table, system, plate scale, with nf = 0 also grid, with
     * stamp = 0 stamp and exposure_s. */
    const char *setup_folder;
} toliman_track_ledger;

/* Options of a tracker. */
typedef struct toliman_track_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_TRACK_READ_ONLY, _REBUILD, _ALLOW_ZERO_RUNS */
    const char *folder; /* created if missing; NULL = in memory, 64 bytes more per frame and 8 per column */
    toliman_track_estimator estimator;
    toliman_track_frames frames;
    toliman_track_grid grid;
    toliman_track_clock clock;
    toliman_track_reduction reduction;
    toliman_track_limits limits;
    toliman_track_ledger ledger;
    uint32_t threads; /* 0 = one per processor, but 1 with `estimate` */
    uint32_t reserved;
    const toliman_allocator *allocator;
    /* Receives one warning per kind of damage that toliman_track_create repairs or ignores
     * (promise: damage-is-told-once). */
    toliman_log_fn log;
    void *log_data;
} toliman_track_options;
#define TOLIMAN_TRACK_OPTIONS_INIT TOLIMAN_INIT(toliman_track_options)

TOLIMAN_END_DECLS

#endif
