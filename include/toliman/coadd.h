/* libtoliman, coadd: adds short frames, 100 per second, to one frame per hour or day. Each frame is registered on the
 * forward model and tested; its counts are added where it lies, without resampling.
 *
 * Data flow (toliman_coadd_...)
 *
 *   toliman_fit, prediction -> create
 *                                |        full: the frame belongs to the next sum
 *   toliman_frame ------------> add -> toliman_coadd_outcome: verdict, place, chi-square
 *                                |
 *                              take -> toliman_frame with toliman_spread -> fit.h, track.h
 *                                |     toliman_coadd_sum
 *   bytes <-> save, load         |
 *                              get_info, destroy
 *
 * A sum keeps the exact counts of each pixel, the photon-weighted mean time, the distribution of the stars' places
 * (spread.h), and the intervals of time with exposures. All sums are integers: frames in any order give the same bits
 * (promise: sums-ignore-the-order). After create, only save and errors allocate memory.
 *
 * Registration: relative flux and shift of both stars, by least squares from model images at steps of 1/8 px. The
 * result depends on the frame only. The separation is that of the prediction; 0.05 px of difference are harmless.
 *
 * A pixel is left out of a frame if its residual is beyond the limit for bad pixels (toliman_frame_goodness: cosmic
 * rays, 6 standard deviations), or if it is saturated or may be. The counts that the registered model expects are added
 * in its place: the expectation of the sum is that of all frames, the variance of the pixel smaller by the share of
 * frames without it. */
#ifndef TOLIMAN_COADD_H
#define TOLIMAN_COADD_H

#include <toliman/fit.h>
#include <toliman/frame.h>

TOLIMAN_BEGIN_DECLS

/* Adds frames of one scene. */
typedef struct toliman_coadd toliman_coadd;

#define TOLIMAN_COADD_ALIGNED 1u /* sums end at multiples of duration_s of the camera time */

/* Options of sums. */
typedef struct toliman_coadd_options {
    uint32_t struct_size;
    uint32_t flags;        /* TOLIMAN_COADD_ALIGNED */
    uint32_t threads;      /* of create */
    uint32_t range_px;     /* largest shift of the stars from their predicted places along x or y, in [1, 16] px; 0 =
                              4 */
    double chi_square_max; /* largest chi-square per degree of freedom of a frame, in (1, inf); 0 = 1.5 */
    double duration_s;     /* longest sum, from the start of its first exposure to the end of its last one, in (0,
                              1e9] s; 0 = no limit */
    double gap_s;          /* longest pause between exposures of a sum, in (0, 1e9] s; 0 = no limit */
    double motion_px;      /* largest distance of the mean of the last 128 places from that of the first 128 of a
                              sum, in (0, 16] px; 0 = no limit. Where a sum ends then depends on the order of frames */
    double pause_s;        /* exposures with shorter pauses are in one interval of the sum, in (0, 1e6] s; 0 = 10 */
    const toliman_allocator *allocator;
    toliman_progress_fn progress; /* while the model images are prepared */
    void *progress_data;
} toliman_coadd_options;
#define TOLIMAN_COADD_OPTIONS_INIT TOLIMAN_INIT(toliman_coadd_options)

/* Creates an object with an empty sum.
 *   fit         of the scene of one short frame; not needed afterwards
 *   prediction  time and expected places of the stars, without spread; NULL: time 0, no shift
 * Model images take 400 bytes per pixel of a frame. Errors: TOLIMAN_E_ARGUMENT if range_px + 1 is beyond capture_px of
 * the fit or half a side of the frame; TOLIMAN_E_UNSUPPORTED for frames of more than 2^22 pixels and detectors
 * with nonlinearity_per_e or brighter_fatter_px2_per_e; TOLIMAN_E_SCENE if
 * the light of the frame does not move with the stars. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_create(const toliman_fit *fit,
                                                                   const toliman_fit_prediction *prediction,
                                                                   const toliman_coadd_options *options,
                                                                   toliman_coadd **out) TOLIMAN_NOEXCEPT;

/* Destroys an object. */
TOLIMAN_API void toliman_coadd_destroy(toliman_coadd *coadd) TOLIMAN_NOEXCEPT;

/* Verdicts on a frame. */
#define TOLIMAN_COADD_VERDICT_ADDED 951
#define TOLIMAN_COADD_VERDICT_NEXT 952      /* take this sum, then add the frame again */
#define TOLIMAN_COADD_VERDICT_LOST 953      /* rows of zeros */
#define TOLIMAN_COADD_VERDICT_FAINT 954     /* less than a fifth of the expected light, or more than 5 times as much */
#define TOLIMAN_COADD_VERDICT_NOT_FOUND 955 /* no stars as the model expects them */
#define TOLIMAN_COADD_VERDICT_OUTSIDE 956   /* stars over range_px from their predicted places */
#define TOLIMAN_COADD_VERDICT_MISFIT 957    /* chi-square above its limit, or more than 256 pixels left out */

/* Why a sum ended. */
#define TOLIMAN_COADD_REASON_NONE 961   /* it did not */
#define TOLIMAN_COADD_REASON_TIME 962   /* duration_s */
#define TOLIMAN_COADD_REASON_GAP 963    /* gap_s */
#define TOLIMAN_COADD_REASON_MOTION 964 /* motion_px */
#define TOLIMAN_COADD_REASON_FULL 965   /* counts near 2^32, more than 64 intervals, or 2^30 frames */
#define TOLIMAN_COADD_REASON_SOURCE 966 /* another session, region or window */

/* Outcome of a frame. */
typedef struct toliman_coadd_outcome {
    uint32_t struct_size;
    int32_t verdict;
    int32_t reason;    /* of NEXT */
    int32_t left_out;  /* pixels, of ADDED */
    int32_t saturated; /* of these; the others are cosmic rays and the like */
    int32_t reserved;
    double flux;                               /* relative to the scene; of ADDED and MISFIT */
    double x_px, y_px, x_sigma_px, y_sigma_px; /* as in toliman_fit_result */
    double chi_square;                         /* per degree of freedom, without the pixels left out */
} toliman_coadd_outcome;
#define TOLIMAN_COADD_OUTCOME_INIT TOLIMAN_INIT(toliman_coadd_outcome)

/* Registers and tests a frame, and adds it to the sum.
 *   frame  with pixels of an unsigned type; counts above 65534 are saturated. camera_ns is the middle of the exposure,
 *          exposure_s its length. Without spread. frame_id and sigma are not used
 * Errors: TOLIMAN_E_ARGUMENT for another shape or a pixel type with sign, and for members that a tracker refuses;
 * TOLIMAN_E_UNSUPPORTED for a window in which bad pixels of the scene move. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_add(toliman_coadd *coadd, const toliman_frame *frame,
                                                                toliman_coadd_outcome *outcome) TOLIMAN_NOEXCEPT;

/* Properties of a sum. */
typedef struct toliman_coadd_sum {
    uint32_t struct_size;
    uint32_t reserved;
    int64_t frames;                                                       /* added */
    int64_t lost, faint, not_found, outside, misfit;                      /* frames with these verdicts */
    int64_t cosmic_rays, saturated;                                       /* pixels left out of added frames */
    int64_t filled_pixels;                                                /* pixels left out of most frames */
    int64_t first_ns, last_ns;                                            /* start of the first and end of the last
                                                                             exposure */
    int64_t mean_ns;                                                      /* photon-weighted mean of the middles of
                                                                             the exposures */
    double photons;                                                       /* of the stars in all frames */
    double flux;                                                          /* mean, relative to the scene */
    double x_px, y_px;                                                    /* photon-weighted mean shift, as of an
                                                                             outcome */
    double registration_xx_px2, registration_yy_px2, registration_xy_px2; /* mean covariance of the registration's
                                                                             errors, subtracted from that of the
                                                                             places */
    double chi_square;                                                    /* mean */
    const uint32_t *left_out;                                             /* [rows][cols]: frames in which a pixel
                                                                             was left out. Belongs to the object */
} toliman_coadd_sum;
#define TOLIMAN_COADD_SUM_INIT TOLIMAN_INIT(toliman_coadd_sum)

/* Ends the sum and begins the next one.
 *   frame  becomes the sum: counts of U32 [rows][cols], number of the sum (frame_id), spread, intervals of exposures,
 *          session, region and window. camera_ns is sum->mean_ns. exposure_s is the length of the shortest time centred
 *          on camera_ns that includes all exposures; the intervals are relative to its start
 * What frame and sum point to belongs to the object and is valid until the next take. Error: TOLIMAN_E_STATE if no
 * frame was added; the counts of other verdicts are then kept for the next sum. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_take(toliman_coadd *coadd, toliman_frame *frame,
                                                                 toliman_coadd_sum *sum) TOLIMAN_NOEXCEPT;

/* Properties and counts of an object. */
typedef struct toliman_coadd_info {
    uint32_t struct_size;
    uint32_t range_px;
    int64_t rows, cols;
    int64_t frames;            /* in the present sum */
    int64_t rejected;          /* frames with other verdicts since it began */
    int64_t number;            /* of the present sum, from 0 */
    int64_t first_ns, last_ns; /* of its exposures; 0 without frames */
    double photons;            /* expected of the stars in one frame */
    uint64_t bytes;            /* of memory */
    uint64_t digest;           /* FNV-1a of all that determines the sums */
} toliman_coadd_info;
#define TOLIMAN_COADD_INFO_INIT TOLIMAN_INIT(toliman_coadd_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_get_info(const toliman_coadd *coadd,
                                                                     toliman_coadd_info *out) TOLIMAN_NOEXCEPT;

/* Saves the present sum as bytes (formats.md, "TLMA"). Equal sums give equal bytes. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_save(const toliman_coadd *coadd, void *bytes,
                                                                 size_t capacity, size_t *needed) TOLIMAN_NOEXCEPT;

/* Continues the sum that was saved as bytes[size], in place of the present one. Errors: TOLIMAN_E_FORMAT for damaged
 * bytes; TOLIMAN_E_MISMATCH for another digest. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_coadd_load(toliman_coadd *coadd, const void *bytes,
                                                                 size_t size) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
