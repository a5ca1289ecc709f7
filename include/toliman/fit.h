/* libtoliman, fit: maximum-likelihood fit of the forward model to each frame, which follows the stars wherever orbit,
 * pointing and roll move them.
 *
 * Data flow (toliman_fit_...)
 *
 *   toliman_sim [count] -> create, destroy -> toliman_fit -> get_parameters, get_info
 *   frames, times, pointing (toliman_fit_prediction), spread -> frame -> toliman_fit_result -> displacement -> period.h
 *                                                               predict -> places of the stars, standard deviations
 *
 * Parameters of a frame, in this order (sim_derivative.h, except that position_angle is in degrees):
 *
 *   separation         px       distance from A to B
 *   position_angle     deg      of B from A on the sky (sim.h, "Angle"), -180 to 180, for a detector without roll
 *   shift_x, shift_y   px       of the scene's centre from its place in the scene; to higher columns, rows
 *   flux_a, flux_b              relative change of the photons of a star
 *   background         photons  per pixel
 *   ...                         toliman_fit_options.free, in the order given: changes against the scene
 *
 * The scene's centre is the barycentre of the light, A or B (binary.centre). It is at the centre of the frame, unless
 * binary.offsets_px gives the places of the stars. */
#ifndef TOLIMAN_FIT_H
#define TOLIMAN_FIT_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim_derivative.h>
#include <toliman/spread.h>

TOLIMAN_BEGIN_DECLS

/* Fit of a scene's forward model. */
typedef struct toliman_fit toliman_fit;

/* Largest number of parameters of a frame. */
#define TOLIMAN_FIT_MAX_PARAMETERS 32u

/* Options of a fit. */
typedef struct toliman_fit_options {
    uint32_t struct_size;
    uint32_t threads;
    const char *free;  /* list of further parameters of sim_derivative.h: "scale focus jitter_xx jitter_yy
                          jitter_xy", but not roll, anisotropy, shear, nor those of the detector. "self": those of
                          jitter_xx, jitter_yy, jitter_xy, focus and zernike_5 to zernike_11 that a frame of the first
                          scene determines to 5 nm or 0.02 px^2: for optics and jitter that drift */
    double capture_px; /* largest shift of both stars from their predicted places along x or y, in (0, 64] px; 0 =
                          15. The place of B relative to A may be about 0.5 px off */
    const toliman_allocator *allocator;
    toliman_progress_fn progress;
    void *progress_data;
} toliman_fit_options;
#define TOLIMAN_FIT_OPTIONS_INIT TOLIMAN_INIT(toliman_fit_options)

/* Creates the fit of a scene, or of several whose optics change with time, as those of a calibration with windows
 * (calibrate.h): model images and predicted places are linear in time between the starts of two windows, constant
 * before the first and after the last. The model images cover the scene's orbit over its cadence, plus capture_px.
 *   sims        [count], the scenes at these starts. The array of one, in C: (const toliman_sim *[]){sim}
 *   first_days  [count], the starts, increasing, days of scene time; may be NULL if count is 1
 * Images between two windows have an error of second order (promise: windows-err-in-second-order): 1e-5 of the peak if
 * the OPD changes by 1 nm.
 * Errors:
 *   - TOLIMAN_E_ARGUMENT for a parameter that is always free; count = 0; starts that do not increase;
 *   - TOLIMAN_E_SCENE if the scene's frame does not determine the parameters: it has too few pixels, a parameter is a
 *     combination of the others, or one has no first-order effect (focus behind a spiral mask without struts);
 *   - TOLIMAN_E_MISMATCH, naming the scene, unless detector.shape, binary and the times of the cadence are the same;
 *   - TOLIMAN_E_UNSUPPORTED for a single star, PADDED_FFT, an accuracy below 1e-14, or a missing derivative. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_create(const toliman_sim *const *sims,
                                                                 const double *first_days, size_t count,
                                                                 const toliman_fit_options *options,
                                                                 toliman_fit **out) TOLIMAN_NOEXCEPT;

/* Destroys a fit. */
TOLIMAN_API void toliman_fit_destroy(toliman_fit *fit) TOLIMAN_NOEXCEPT;

/* Writes the parameters of a frame, in the order of its values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_get_parameters(const toliman_fit *fit,
                                                                         toliman_sim_parameter *parameters,
                                                                         size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Properties of a fit. With several windows, `images` is the sum over the windows; oversampling, taps and image_error
 * are the largest of a window. */
typedef struct toliman_fit_info {
    uint32_t struct_size;
    uint32_t oversampling; /* samples of the model images per pixel and axis */
    int64_t rows, cols;
    uint32_t taps;      /* samples per axis that interpolate a pixel */
    uint32_t images;    /* model images */
    int64_t parameters; /* of a frame: 7 and those of the options */
    double image_error; /* of the interpolation, relative to the peak of the model image */
    double capture_px;
    uint64_t digest; /* FNV-1a of all that determines results, except the states of an observer file and on-target
                        intervals, which grow */
} toliman_fit_info;
#define TOLIMAN_FIT_INFO_INIT TOLIMAN_INIT(toliman_fit_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_get_info(const toliman_fit *fit,
                                                                   toliman_fit_info *out) TOLIMAN_NOEXCEPT;

/* Prediction of a frame. The fit starts at the predicted places; displacement_px is measured from the predicted
 * separation. */
typedef struct toliman_fit_prediction {
    uint32_t struct_size;
    uint32_t flags;
    double time_days;             /* time of the frame, at which the scene's orbit gives the places of moving stars;
                                     with binary.observer, apparent places, averaged over the scene's exposure */
    double x_px, y_px;            /* shift of both stars from their places in the scene */
    double separation_px;         /* 0 = that of the scene at this time */
    double position_angle_deg;    /* with separation_px */
    const toliman_spread *spread; /* of a sum of frames; NULL = one frame of the scene. Banks and calibrations:
                                     TOLIMAN_E_UNSUPPORTED. Fluxes are relative to those of all frames, background is
                                     per pixel of the sum. The shift must stay below capture_px by about 6 standard
                                     deviations of the spread: 2 px for 0.3 px */
} toliman_fit_prediction;
#define TOLIMAN_FIT_PREDICTION_INIT TOLIMAN_INIT(toliman_fit_prediction)

/* Flag: no maximum: the last step moved a place by 1e-6 px or more, a star lost 90 % of its flux, or the stars left the
 * range of the model images. Without a maximum every number of a fit is NaN (promise: unfitted-frames-are-nan), except
 * iterations; excluded is 0. */
#define TOLIMAN_FIT_NOT_CONVERGED 1u

#define TOLIMAN_FIT_SATURATED 4u /* pixels at the full well or the largest count were excluded */
#define TOLIMAN_FIT_EDGE 8u      /* a star is outside the frame, or over capture_px from its predicted x or y */
#define TOLIMAN_FIT_SEARCHED 16u /* a search found the stars away from their predicted places */

/* Result for one frame. */
typedef struct toliman_fit_result {
    uint32_t struct_size;
    uint32_t flags;         /* TOLIMAN_FIT_... */
    double displacement_px; /* separation_px minus the predicted separation */
    double separation_px;
    double separation_sigma_px; /* standard deviations: from the inverse Fisher matrix */
    double position_angle_deg, position_angle_sigma_deg;
    double x_px, y_px, x_sigma_px, y_sigma_px; /* of the scene's centre */
    double flux_a, flux_b;                     /* relative change of the photons */
    double background;                         /* photons per pixel */
    double chi_square;                         /* goodness.h: without the bad pixels */
    int32_t iterations;                        /* Gauss-Newton */
    int32_t excluded;                          /* pixels saturated, or expected within 5 standard deviations of
                                                  saturation */
    double chi_square_sigma;
    double largest_residual;
    int32_t goodness;    /* TOLIMAN_GOODNESS_...; UNKNOWN with NOT_CONVERGED */
    uint32_t bad_pixels; /* left out: see toliman_frame_goodness */
} toliman_fit_result;
#define TOLIMAN_FIT_RESULT_INIT TOLIMAN_INIT(toliman_fit_result)

/* Fits `count` frames of image. A call with one frame of doubles allocates memory only if more calls run at the same
 * time than ever before.
 *   predictions  [count]; NULL: time 0, no shift
 *   results      [count]
 *   values       [count][n], or NULL: all n = toliman_fit_info.parameters parameters
 *   covariance   [count][n][n], or NULL: their covariance, the inverse Fisher matrix (promise: covariances-are-bounds)
 * A frame that cannot be fitted is not an error: see the flags. Bad pixels are left out of the fit; where none is
 * found, the search for them changes no bit. The result of a fit depends on the frame and its prediction only
 * (promise: fits-ignore-other-frames).
 * Errors: image.h; TOLIMAN_E_ARGUMENT for a prediction outside the range of the model images. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_frame(const toliman_fit *fit, const toliman_image *image,
                                                                size_t count, const toliman_fit_prediction *predictions,
                                                                toliman_fit_result *results, double *values,
                                                                double *covariance) TOLIMAN_NOEXCEPT;

/* Writes what a fit of an undisturbed frame with this prediction would return: the expected frame to
 * image[rows][stride], the parameters to values[n] and their covariance, the Cramer-Rao bound, to covariance[n][n];
 * each may be NULL. Errors: as toliman_fit_frame. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_predict(const toliman_fit *fit,
                                                                  const toliman_fit_prediction *prediction,
                                                                  double *image, size_t stride, double *values,
                                                                  double *covariance) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
