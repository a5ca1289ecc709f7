/* libtoliman, downlinked frames, and user-supplied estimators that reduce them to a value.
 *
 * Data flow
 *
 *   toliman_frame -> track.h -> toliman_estimate_input -> toliman_estimate_fn -> toliman_estimate -> track.h */
#ifndef TOLIMAN_FRAME_H
#define TOLIMAN_FRAME_H

#include <toliman/image.h>
#include <toliman/spread.h>

TOLIMAN_BEGIN_DECLS

/* Point of the exposure to which the time stamps of a file refer. */
#define TOLIMAN_FRAME_STAMP_START 601
#define TOLIMAN_FRAME_STAMP_MIDDLE 602
#define TOLIMAN_FRAME_STAMP_END 603

/* Downlinked frame. As an input, its pixels and intervals are not needed after the call; as an output of
 * toliman_ingest_next, they belong to the reader. Its key is session, restarts, roi and frame_id. Its content is its
 * pixels, their type and shape, camera_ns, dropped, sigma, exposure_s, intervals, window, spread. A second valid frame
 * with the same key is a duplicate if its content is the same, otherwise both are quarantined
 * (promise: conflicting-frames-are-quarantined). */
typedef struct toliman_frame {
    uint32_t struct_size;
    int32_t pixel;       /* TOLIMAN_PIXEL_..., without a default */
    const char *session; /* 1 to 64 characters A-Z a-z 0-9 . _ -, not starting with a dot */
    const char *roi;     /* region of interest, likewise */
    int64_t frame_id;    /* may be negative */
    int64_t camera_ns;   /* time by the camera clock, usually of the middle of the exposure */
    int64_t dropped;     /* frames dropped by the camera before this one, counted up to 16777215; 0 = none or unknown */
    const void *pixels;  /* [rows][stride], aligned to the size of a pixel */
    int64_t rows, cols;
    int64_t stride;                 /* 0 = cols */
    double sigma;                   /* of this frame's value, 1 to 32 times the tracker's; 0 = the tracker's */
    double exposure_s;              /* at most 1e9 s; 0 = unknown */
    const double *intervals;        /* [interval_count][2]: on-target intervals (good-time intervals) in s from the
                                       start of the exposure, increasing and within it; NULL without */
    size_t interval_count;          /* at most 65536; 0 = unknown */
    int64_t window_row, window_col; /* of the first pixel on the detector, at most 2^31; 0, 0 = that of the scene, as
                                       frames of raw pairs have it */
    int64_t restarts;               /* of the camera within the session before this frame, after which its ids begin
                                       again; 0 to 2^31 */
    const toliman_spread *spread;   /* of a sum of frames (coadd.h), for trackers with fit or estimate (others:
                                       TOLIMAN_E_UNSUPPORTED); NULL = one frame */
} toliman_frame;
#define TOLIMAN_FRAME_INIT TOLIMAN_INIT(toliman_frame)

/* Input of a user-supplied estimator: image after cropping and binning; others as in toliman_frame. */
typedef struct toliman_estimate_input {
    uint32_t struct_size;
    uint32_t reserved;
    const double *image; /* [rows][stride] */
    size_t rows, cols, stride;
    int64_t tai_ns;        /* by the tracker's clock table */
    double variance_scale; /* (sigma of the frame / sigma of the tracker)^2 */
    double exposure_s;
    const double *intervals; /* [interval_count][2] */
    size_t interval_count;
    int64_t window_row, window_col; /* of the image's first pixel on the detector */
    const toliman_spread *spread;
} toliman_estimate_input;
#define TOLIMAN_ESTIMATE_INPUT_INIT TOLIMAN_INIT(toliman_estimate_input)

/* Output of a user-supplied estimator. The library provides both arrays, and presets their elements and chi_square to
 * NaN, flags and sigma to 0. */
typedef struct toliman_estimate {
    uint32_t struct_size;
    uint32_t flags;     /* defined by the estimator; ledger column "flags" */
    double *values;     /* [value_count]: values[0] is the value of the frame, the others are columns */
    size_t value_count; /* 1 + names in toliman_track_estimator.values */
    double *covariance; /* [value_count][value_count], upper triangle; columns, except the variance of values[0],
                           which is sigma^2 */
    double sigma;       /* of values[0], 1 to 32 times the tracker's; 0 = the frame's, or the tracker's */
    double chi_square;  /* per pixel; NaN = unknown */
} toliman_estimate;
#define TOLIMAN_ESTIMATE_INIT TOLIMAN_INIT(toliman_estimate)

/* User-supplied estimator. Its result must depend on *input only. A nonzero return value, a non-finite values[0] or a
 * sigma out of range rejects the frame (promise: bad-estimates-reject-frames). With several threads, all call it
 * concurrently. */
typedef int32_t (*toliman_estimate_fn)(const toliman_estimate_input *input, toliman_estimate *estimate,
                                       void *user_data);

TOLIMAN_END_DECLS

#endif
