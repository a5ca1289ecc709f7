/* libtoliman, calibrate: parameters of the telescope, learned from frames of the binary itself. The separation that a
 * fit (fit.h) measures is only as accurate as its model of the optics: with 20 nm of unknown aberrations it is wrong by
 * 1e-3 px, in a way that depends on the pointing. The pattern of a mask determines the optics from ten frames well
 * enough that their error costs the separation less than 1 % of its standard deviation.
 *
 * Data flow (functions toliman_calibration_...)
 *
 *   toliman_sim (nominal scene), frames, times -> toliman_calibrate -> toliman_calibration
 *                                                  (options_init)          |
 *   values, errors, verdict              get_info, get_value, get_covariance, get_frame
 *   images                               get_opd, get_chi_map, get_residual
 *   fitted scene, for all other uses     save_file, get_window
 *                                        destroy
 *
 * Parameters of the instrument, which have the same value in all frames of a window, as in sim_derivative.h:
 *
 *   scale, anisotropy, shear   focus, zernike_5 ... _36   mask_rotation, mask_shift_x, _y   jitter_xx, _yy, _xy
 *   temperature_a, _b   spectrum_a_1 ... _11, spectrum_b_1 ... _11
 *
 * Their values are changes against the nominal scene. Each has a normal prior around 0. All parameters and those of
 * each frame (places, fluxes, background; fit.h) are fitted together: by maximum likelihood with Levenberg-Marquardt
 * steps, where the parameters of each frame are eliminated exactly. With TOLIMAN_CALIBRATION_MAP, the OPD of each pupil
 * cell is fitted afterwards, which takes minutes.
 *
 * What frames cannot tell:
 *   - Position angle cannot be told from roll of the spacecraft, nor Zernike tilts from pointing. Neither roll
 *     nor tilts are parameters.
 *   - Without struts, the pupil of a spiral mask with odd m is antisymmetric: the sign of the aberrations of even
 *     azimuthal order changes neither frames nor separations (TOLIMAN_CALIBRATION_NO_SIGN).
 *   - Scale is measured in wavelengths: an error of the spectra causes an error of the scale. Absolute scale is
 *     known only as well as the spectra are, by their priors. Separations in px do not depend on it.
 *
 * The fitted scene has a group `calibration` with pupil_samples, step_nm, edges and accuracy of the calibration, which
 * are part of the model: a scene that contradicts them is refused.
 */
#ifndef TOLIMAN_CALIBRATE_H
#define TOLIMAN_CALIBRATE_H

#include <toliman/fit.h>

TOLIMAN_BEGIN_DECLS

/* Result of a calibration. Several threads may use it at the same time. */
typedef struct toliman_calibration toliman_calibration;

/* Flag of options: fit also the OPD of each pupil cell. */
#define TOLIMAN_CALIBRATION_MAP 1u

/* An iteration of a calibration. */
typedef struct toliman_calibration_step {
    uint32_t struct_size;
    uint32_t map;        /* 1: of the OPD map; 0: of the parameters */
    int32_t iteration;   /* 1, 2, ...; the numbers continue from the parameters to the map */
    uint32_t accepted;   /* 0: the step was rejected */
    double chi_square;   /* sum of squared residuals over their variances, per degree of freedom */
    double largest_step; /* of a parameter of the instrument, in its standard deviations; of the map: rms in nm */
} toliman_calibration_step;
#define TOLIMAN_CALIBRATION_STEP_INIT TOLIMAN_INIT(toliman_calibration_step)

/* Called after each iteration on the thread of the caller. so_far is valid during the call. It has values, but no
 * standard deviations, and its info has the flag NOT_CONVERGED. It may be saved: a later calibration may start from its
 * scene. A nonzero value cancels. */
typedef int32_t (*toliman_calibration_step_fn)(const toliman_calibration *so_far, const toliman_calibration_step *step,
                                               void *user_data);

/* Options of a calibration. */
typedef struct toliman_calibration_options {
    uint32_t struct_size;
    uint32_t flags;   /* TOLIMAN_CALIBRATION_MAP, or 0 */
    const char *free; /* parameters to fit, separated by spaces: NAME, NAME=SIGMA or NAME-LAST, such as "scale=1e-3
                         focus zernike_5-21=50 mask_rotation", with the standard deviation of the prior in the
                         parameter's unit. NULL: all that the scene has of "focus zernike_5-21 scale mask_rotation
                         jitter_xx jitter_yy jitter_xy temperature_a temperature_b". Priors without SIGMA:
                         aberrations 100 nm, scale, anisotropy and shear 1e-2, mask_rotation 1 deg, mask shifts 1e-4 m,
                         jitter 0.1 px^2, temperatures 200 K, spectral modes 0.1 */
    const toliman_sim *start; /* scene to start from, such as the saved one of a calibration that was interrupted;
                                 NULL: the nominal scene. Priors remain around the nominal scene */
    int32_t most_iterations;  /* of the parameters, and again of the map; 0 = 30, at most 1000 */
    uint32_t threads;         /* worker threads, 0 = one per processor. Results do not depend on them */
    double capture_px;        /* largest shift of both stars from their predicted places along x or y, px;
                                 0 = 6, at most 64 */
    double window_days;       /* length of the windows in which the parameters are constant, days; 0: one window
                                 for all frames */
    double smoothness;        /* with windows: standard deviation of the change of each parameter from one window to
                                 the next, in units of prior_sigma; 0 = 0.01 */
    double map_rms_nm;        /* prior of the map: its rms over the open pupil, nm; 0 = 10. Its power spectrum falls
                                 as frequency^-2.5 above 4 cycles per aperture, and is constant below */
    toliman_calibration_step_fn step; /* may be NULL */
    void *step_data;
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
} toliman_calibration_options;
#define TOLIMAN_CALIBRATION_OPTIONS_INIT TOLIMAN_INIT(toliman_calibration_options)

/* Sets *options, a struct of `size` bytes, to the defaults. */
TOLIMAN_API void toliman_calibration_options_init(toliman_calibration_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Calibrates a scene with `count` frames of image, and writes the result to *out, which the caller destroys.
 *   sim          nominal scene, not needed afterwards
 *   image        frames in the unit of the scene's frames (photons, electrons or DN); variances are those of the
 *                scene's detector and noise
 *   predictions  [count], times and expected places of the stars; NULL: times of the scene's frames 0 to count - 1, no
 *                shift
 *   options      may be NULL
 * Memory: the frames, plus an amount almost independent of their number. The result does not depend on threads.
 * Without convergence the call succeeds, with TOLIMAN_CALIBRATION_NOT_CONVERGED.
 * Errors:
 *   - TOLIMAN_E_ARGUMENT for a count that is not finite, naming its frame, row and column; for frames that do not have
 *     the scene's shape; for a parameter that is unknown, named twice, or always free; for a frame whose stars are not
 *     found within capture_px; for fewer than 2 frames; for more than 4096 parameters times windows;
 *   - TOLIMAN_E_UNSUPPORTED for a single star; with PADDED_FFT; for a parameter that was named and that the scene does
 *     not have; for position_angle, roll and wavelength;
 *   - TOLIMAN_E_MISMATCH if options->start has other pupil cells, aperture, step of the mask, wavelengths, or shape of
 *     the frames than the nominal scene. Nothing else of it is compared;
 *   - TOLIMAN_E_CANCELLED if step returned a nonzero value. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibrate(const toliman_sim *sim, const toliman_image *image,
                                                                size_t count, const toliman_fit_prediction *predictions,
                                                                const toliman_calibration_options *options,
                                                                toliman_calibration **out) TOLIMAN_NOEXCEPT;

/* Destroys a calibration. NULL is allowed. */
TOLIMAN_API void toliman_calibration_destroy(toliman_calibration *calibration) TOLIMAN_NOEXCEPT;

/* Flag of a calibration: no maximum was found. Values, standard deviations and images of the fitted instrument are NaN.
 */
#define TOLIMAN_CALIBRATION_NOT_CONVERGED 1u

/* Flag: the frames have an effect that the model lacks. chi_square is more than 6 standard deviations above 1, or
 * structure is above structure_limit. */
#define TOLIMAN_CALIBRATION_INCOMPLETE 2u

#define TOLIMAN_CALIBRATION_HELD 4u    /* a parameter is known mostly by its prior */
#define TOLIMAN_CALIBRATION_NO_SIGN 8u /* the sign of even aberrations is undetermined */

/* Summary of a calibration. */
typedef struct toliman_calibration_info {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_info) */
    uint32_t flags;       /* TOLIMAN_CALIBRATION_..., the verdict; 0: converged, and the model is complete */
    int64_t frames;       /* frames that were calibrated */
    int64_t rows, cols;   /* shape of the frames */
    int64_t cells;        /* pupil cells per axis, N */
    uint32_t parameters;  /* number of parameters of the instrument, in each window */
    uint32_t windows;     /* number of windows */
    int32_t iterations;   /* of the parameters, the rejected ones included */
    int32_t map_iterations;
    double chi_square;       /* sum of squared residuals over their variances, per degree of freedom */
    double chi_square_sigma; /* its standard deviation, if the model is right */
    double structure; /* sum over the neighbours (0,1), (1,0), (1,1), (1,-1), (0,2), (2,0) of the squared correlation of
                         the residuals with those of the neighbour, in units of its variance: for white residuals
                         chi-square distributed with 6 degrees of freedom */
    double structure_limit;      /* 50: exceeded by white residuals once in 2e8 calibrations; with a map, which fits
                                    some of the noise, plus pixels times (1 - chi_square)^2 */
    double separation_sigma_px;  /* standard deviation of the separation in a frame (median), all parameters
                                    of the frame free and those of the instrument known */
    double calibration_sigma_px; /* standard deviation of the error that the uncertain parameters of the instrument
                                    cause in the separation of a frame (median); without that of the map */
    double map_rms_nm;           /* rms of the fitted map over the open pupil, nm; 0 without a map */
} toliman_calibration_info;
#define TOLIMAN_CALIBRATION_INFO_INIT TOLIMAN_INIT(toliman_calibration_info)

/* Writes the summary of a calibration to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_info(const toliman_calibration *calibration, toliman_calibration_info *out) TOLIMAN_NOEXCEPT;

/* A fitted parameter of the instrument. */
typedef struct toliman_calibration_value {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_value) */
    uint32_t flags;       /* TOLIMAN_CALIBRATION_HELD: sigma is above 0.7 prior_sigma; _NO_SIGN: the sign of
                             all such values together is undetermined; the first one is >= 0 */
    const char *name;     /* such as "zernike_7"; static text */
    const char *unit;     /* such as "nm", "" for a relative change; static text */
    double value;         /* change against the nominal scene */
    double sigma;         /* standard deviation, all other parameters free */
    double prior_sigma;   /* that of the prior */
} toliman_calibration_value;
#define TOLIMAN_CALIBRATION_VALUE_INIT TOLIMAN_INIT(toliman_calibration_value)

/* Writes parameter number `index` in a window to *out, whose struct_size must be set. TOLIMAN_E_RANGE unless
 * 0 <= index < parameters and 0 <= window < windows. With a map, the values exclude the map,
 * which adds to their aberrations. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_value(const toliman_calibration *calibration, int64_t window, int32_t index,
                              toliman_calibration_value *out) TOLIMAN_NOEXCEPT;

/* Writes the covariance of the parameters in a window, with those of the frames free, to covariance[n][n]; n is the
 * number of parameters. TOLIMAN_E_RANGE as for toliman_calibration_get_value. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_covariance(const toliman_calibration *calibration,
                                                                                 int64_t window,
                                                                                 double *covariance) TOLIMAN_NOEXCEPT;

/* Writes the parameters of frame number `index`, 0 <= index < frames, to *out, whose struct_size must be set: as
 * toliman_fit_frame with the fitted scene, where the standard deviations include the uncertainty of the instrument. A
 * scene with cadence.peak_photons gives its own peak that number of photons: fluxes are then relative to the nominal
 * scene. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_frame(const toliman_calibration *calibration,
                                                                            int64_t index,
                                                                            toliman_fit_result *out) TOLIMAN_NOEXCEPT;

/* A window of a calibration: first_days <= time < first_days of the next window. */
typedef struct toliman_calibration_window {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_window) */
    uint32_t reserved;
    int64_t frames;    /* number of its frames */
    double first_days; /* start, days of scene time; the first window also holds all earlier times */
    double chi_square; /* of its frames, per degree of freedom */
} toliman_calibration_window;
#define TOLIMAN_CALIBRATION_WINDOW_INIT TOLIMAN_INIT(toliman_calibration_window)

/* Writes window number `window` to *out, whose struct_size must be set. TOLIMAN_E_RANGE unless 0 <= window < windows.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_window(
    const toliman_calibration *calibration, int64_t window, toliman_calibration_window *out) TOLIMAN_NOEXCEPT;

/* Writes the change of the OPD (m) against the nominal scene in a window, parameters and map together, to opd[N][N];
 * 0 where the pupil is closed. TOLIMAN_E_RANGE as for toliman_calibration_get_window. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_opd(const toliman_calibration *calibration,
                                                                          int64_t window, double *opd) TOLIMAN_NOEXCEPT;

/* Writes the mean over all frames of the squared residual over its variance to map[rows][stride]; stride >= cols, in
 * elements. 0 for pixels that were excluded in all frames. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_chi_map(const toliman_calibration *calibration,
                                                                              double *map,
                                                                              size_t stride) TOLIMAN_NOEXCEPT;

/* Writes the residual of the first frame over its standard deviation to image[rows][stride]. fitted: 1 = at the fitted
 * values, 0 = at those from which the calibration started. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_residual(const toliman_calibration *calibration,
                                                                               int32_t fitted, double *image,
                                                                               size_t stride) TOLIMAN_NOEXCEPT;

/* Saves the fitted scene of a window at `path`, a name that ends in ".json", and its map, if there is one, in the same
 * folder as <name>.opd.npy. Relative file names are rewritten relative to this folder. Replaces
 * the files atomically. TOLIMAN_E_UNSUPPORTED if the calibration did not converge; TOLIMAN_E_WRITE. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_save_file(const toliman_calibration *calibration,
                                                                            int64_t window,
                                                                            const char *path) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
