/* libtoliman, fit: maximum-likelihood fit of the forward model to each frame, which follows the stars wherever orbit,
 * pointing and roll move them. A bank of networks (bank.h) follows them along their orbit; the other estimators are
 * made for stars at rest.
 *
 * Data flow (functions toliman_fit_...)
 *
 *   toliman_sim [count] -> create -> toliman_fit -> frame -> toliman_fit_result -> displacement, px -> period.h
 *                                      |     ^      predict -> places of the stars, standard deviations
 *                                      |     |      get_parameters, get_info
 *                                   destroy  time of the frame, pointing (toliman_fit_prediction), spread
 *
 * The parameters of a frame are, in this order (names and units as in sim_derivative.h, except that position_angle is
 * in degrees):
 *
 *   separation         px       distance from A to B
 *   position_angle     deg      of B from A on the sky, north through east, from -180 to 180; the detector is assumed
 *                               not to roll
 *   shift_x, shift_y   px       shift of the scene's centre from its place in the scene; x towards higher columns, y
 *                               towards higher rows
 *   flux_a, flux_b              relative change of the photons of a star
 *   background         photons  equal light on every pixel
 *   ...                         those of toliman_fit_options.free, in the order given: changes against the scene
 *
 * The scene's centre is the barycentre of the light, A or B (binary.centre). It is at the centre of the frame, unless
 * binary.offsets_px gives the places of the stars.
 */
#ifndef TOLIMAN_FIT_H
#define TOLIMAN_FIT_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim_derivative.h>
#include <toliman/spread.h>

TOLIMAN_BEGIN_DECLS

/* Fit of a scene's forward model. Several threads may use it at the same time. */
typedef struct toliman_fit toliman_fit;

/* Largest number of parameters of a frame. */
#define TOLIMAN_FIT_MAX_PARAMETERS 32u

/* Options of a fit. */
typedef struct toliman_fit_options {
    uint32_t struct_size;
    uint32_t threads;  /* worker threads, 0 = one per processor */
    const char *free;  /* further free parameters, a list of names of sim_derivative.h:
                                           "scale focus jitter_xx jitter_yy jitter_xy". NULL or "": none. Those that
                                           move the stars (roll, anisotropy, shear) are not available. "self" stands
                                           for the self-calibration: those of jitter_xx, jitter_yy, jitter_xy, focus and
                                           zernike_5 to zernike_11 that a frame of the (first) scene determines to 5 nm
                                           and 0.02 px^2. Optics and jitter may then drift */
    double capture_px; /* largest shift of both stars from their predicted places along x or y, in (0, 64] px; 0 = 15.
                          Stars that moved relative to each other are found up to about 0.5 px from the predicted
                          separation and position angle */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    toliman_progress_fn progress;       /* called while the model images are prepared; may be NULL */
    void *progress_data;
} toliman_fit_options;
#define TOLIMAN_FIT_OPTIONS_INIT TOLIMAN_INIT(toliman_fit_options)

/* Creates the fit of a scene, or of several whose optics change with time, as those of a calibration with windows
 * (calibrate.h) do: model images and predicted places are linear in time between the starts of two windows. The model
 * images cover the scene's orbit over its cadence, plus capture_px. The caller destroys *out.
 *   sims        [count], the scenes at these starts, not needed afterwards. The array of one simulator, in C:
 *               (const toliman_sim *[]){sim}
 *   first_days  [count], the starts of the windows, increasing, days of scene time; may be NULL if count is 1. At
 *               first_days[i] the model is that of sims[i]; before the first start and after the last one it is
 *               constant. The time of a frame is that of its prediction
 *   options     may be NULL
 * Images between two windows have an error of second order (promise: windows-err-in-second-order): about (2 pi
 * d/wavelength)^2/8 of the peak where the OPD changes by d from one scene to the next, 1e-5 for 1 nm. With several
 * windows, the digest of toliman_fit_info is that of all of them and their starts, images is their sum, and
 * oversampling, taps and image_error are the largest. A bank needs the fit of one scene.
 * Errors:
 *   - TOLIMAN_E_ARGUMENT for an unknown parameter, or one that is named twice or always free, for count = 0, and for
 *     starts that are not finite or do not increase;
 *   - TOLIMAN_E_SCENE if the scene's frame does not determine the parameters: it has too few pixels, a parameter is a
 *     combination of the others, or one has no first-order effect (focus behind a spiral mask without struts);
 *   - TOLIMAN_E_MISMATCH, naming the scene, unless detector.shape, binary and the times of the cadence are the same;
 *   - TOLIMAN_E_UNSUPPORTED for a single star, with PADDED_FFT, for an accuracy below 1e-14, or if the scene has no
 *     derivative by a parameter;
 *   - TOLIMAN_E_CANCELLED if progress returned a nonzero value. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_create(const toliman_sim *const *sims,
                                                                 const double *first_days, size_t count,
                                                                 const toliman_fit_options *options,
                                                                 toliman_fit **out) TOLIMAN_NOEXCEPT;

/* Destroys a fit. NULL is allowed. */
TOLIMAN_API void toliman_fit_destroy(toliman_fit *fit) TOLIMAN_NOEXCEPT;

/* Writes the parameters of a frame, in the order of its values, to parameters[capacity] and their number to *count.
 * TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_get_parameters(const toliman_fit *fit,
                                                                         toliman_sim_parameter *parameters,
                                                                         size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Properties of a fit. */
typedef struct toliman_fit_info {
    uint32_t struct_size;  /* in: sizeof(toliman_fit_info) */
    uint32_t oversampling; /* samples of the model images per pixel and axis */
    int64_t rows, cols;    /* shape of the frames */
    uint32_t taps;         /* samples per axis that interpolate a pixel of a model image */
    uint32_t images;       /* model images in memory */
    int64_t parameters;    /* of a frame: 7 and those of toliman_fit_options.free */
    double image_error;    /* predicted error of the interpolation, relative to the peak of the model image */
    double capture_px;     /* as in the options */
    uint64_t digest; /* FNV-1a of all that determines results: model images, detector, orbit, parameters, capture */
} toliman_fit_info;
#define TOLIMAN_FIT_INFO_INIT TOLIMAN_INIT(toliman_fit_info)

/* Writes the properties of a fit to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_get_info(const toliman_fit *fit,
                                                                   toliman_fit_info *out) TOLIMAN_NOEXCEPT;

/* What is known of a frame before the fit. The fit starts at the predicted places. From any start that converges to the
 * same maximum, places agree to about 1e-7 px. displacement_px is measured from the predicted separation. */
typedef struct toliman_fit_prediction {
    uint32_t struct_size;
    uint32_t flags;            /* 0 */
    double time_days;          /* time of the frame: a moving binary is at its place on the scene's orbit, or, with
                                  binary.observer, where the observer sees it: mean over the scene's exposure */
    double x_px, y_px;         /* expected shift of both stars from their places in the scene, as shift_x and shift_y */
    double separation_px;      /* 0 = that of the scene at this time */
    double position_angle_deg; /* with separation_px; ignored if that is 0 */
    const toliman_spread *spread; /* of a sum of frames; NULL = one frame of the scene. Banks, and calibrations of a
                                     map, refuse it (TOLIMAN_E_UNSUPPORTED). Fluxes are relative to those of all
                                     frames, background is per pixel of the sum. The model images, made for the
                                     frame, are wrong within about 6 standard deviations of the spread, 2 px for
                                     0.3 px, from capture_px */
} toliman_fit_prediction;
#define TOLIMAN_FIT_PREDICTION_INIT TOLIMAN_INIT(toliman_fit_prediction)

/* Flag of a result without a maximum: the last step moved a place by 1e-6 px or more, a star lost 90 % of its flux, or
 * the stars left the range of the model images. Without a maximum every number of a fit is NaN
 * (promise: unfitted-frames-are-nan), except iterations; excluded is 0. Frequent if photons and read noise together are
 * below about 1 electron^2 in many pixels. Without this flag, the result is the maximum of the likelihood near the
 * prediction, or near the places found by the search. */
#define TOLIMAN_FIT_NOT_CONVERGED 1u

#define TOLIMAN_FIT_SATURATED 4u /* pixels at the full well or the largest count were excluded */
#define TOLIMAN_FIT_EDGE 8u      /* a star is outside the frame, or over capture_px from its predicted x or y */
#define TOLIMAN_FIT_SEARCHED 16u /* the stars were not at their predicted places; a search found them */

/* Result for one frame. */
typedef struct toliman_fit_result {
    uint32_t struct_size;       /* in: sizeof(toliman_fit_result) */
    uint32_t flags;             /* TOLIMAN_FIT_... */
    double displacement_px;     /* separation_px minus the predicted separation */
    double separation_px;       /* distance from A to B */
    double separation_sigma_px; /* standard deviations: square roots of the diagonal of the inverse Fisher matrix */
    double position_angle_deg, position_angle_sigma_deg;
    double x_px, y_px, x_sigma_px, y_sigma_px; /* shift of the scene's centre */
    double flux_a, flux_b;                     /* relative change of the photons of a star */
    double background;                         /* photons per pixel */
    double chi_square;                         /* per degree of freedom, without the bad pixels */
    int32_t iterations;                        /* Gauss-Newton steps */
    int32_t excluded;        /* saturated pixels, those expected within 5 standard deviations of saturation included */
    double chi_square_sigma; /* standard deviation of chi_square, if the scene is right */
    double largest_residual; /* largest |residual| over its standard deviation */
    int32_t goodness;        /* verdict on chi_square, TOLIMAN_GOODNESS_...; UNKNOWN with NOT_CONVERGED */
    uint32_t bad_pixels;     /* cosmic rays, hot and dead pixels that were left out: see toliman_frame_goodness */
} toliman_fit_result;
#define TOLIMAN_FIT_RESULT_INIT TOLIMAN_INIT(toliman_fit_result)

/* Fits `count` frames of image, on the threads of the fit's options; one frame on the calling thread. Fitting one frame
 * of doubles allocates memory only if more calls run at the same time than before.
 *   predictions  [count]; NULL: time 0, no shift
 *   results      [count]; struct_size of the first must be set
 *   values       [count][n], or NULL: all n = toliman_fit_info.parameters parameters, as listed at the top
 *   covariance   [count][n][n], or NULL: their covariance, the inverse Fisher matrix (promise: covariances-are-bounds)
 * A frame that cannot be fitted is not an error: see the flags. Bad pixels are left out of the fit; where none is
 * found, the search for them changes no bit of the result. The result of a fit depends on the frame and its prediction
 * only (promise: fits-ignore-other-frames). Errors, which name the frame if there are several: TOLIMAN_E_ARGUMENT for
 * another shape, for a non-finite count, naming its row and column, and for a prediction that is not finite or outside
 * the range of the model images; TOLIMAN_E_RANGE for an image larger than the address space. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_frame(const toliman_fit *fit, const toliman_image *image,
                                                                size_t count, const toliman_fit_prediction *predictions,
                                                                toliman_fit_result *results, double *values,
                                                                double *covariance) TOLIMAN_NOEXCEPT;

/* Writes what a fit of an undisturbed frame with this prediction would return: the expected frame to
 * image[rows][stride] (NULL: not computed), the parameters to values[n] and their covariance, the Cramer-Rao bound, to
 * covariance[n][n] (either may be NULL). Errors: as toliman_fit_frame; TOLIMAN_E_ARGUMENT for a smaller stride. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_fit_predict(const toliman_fit *fit,
                                                                  const toliman_fit_prediction *prediction,
                                                                  double *image, size_t stride, double *values,
                                                                  double *covariance) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
