/* libtoliman, calibrate: parameters of the telescope, learned from frames of the binary itself.
 *
 * Data flow (toliman_calibration_...)
 *
 *   toliman_sim (nominal scene), frames, times -> create, destroy -> toliman_calibration
 *   values, errors, verdict              get_info, get_value, get_covariance, get_frame
 *   what the model lacks                 get_attempt, get_left_out
 *   images, response of the pixels       get_opd, get_image
 *   fitted scene, for all other uses     save_file, get_window
 *
 * Parameters of the instrument (sim_derivative.h), which are constant or, with windows, linear in time from the start
 * of a window to that of the next: scale, anisotropy, shear, focus, zernike_5 ... _36, mask_rotation, mask_shift_x,
 * _y, jitter_xx, _yy, _xy, temperature_a, _b, spectrum_a_1 ... _11, spectrum_b_1 ... _11, and those of the detector:
 * diffusion (instead of jitter_xx and jitter_yy), transfer_smear, brighter_fatter, interpixel_capacitance,
 * nonlinearity. Values are changes against the nominal scene, each with a normal prior around 0. They are fitted
 * together with the parameters of each frame (fit.h), by maximum likelihood.
 *
 * Frames do not determine
 *   - roll of the spacecraft and tilts: position angle and pointing contain them;
 *   - the sign of aberrations of even azimuthal order, for a spiral mask with odd m without struts, and the absolute
 *     scale, which follows from the priors of the spectra: separations in px depend on neither.
 *
 * A scene that contradicts its calibration is refused (promise: contradicting-scenes-are-refused).
 *
 * A model that lacks an effect gives separations that are wrong by many standard deviations: check flags and lacks of
 * toliman_calibration_info, and try TOLIMAN_CALIBRATION_IMPROVE. */
#ifndef TOLIMAN_CALIBRATE_H
#define TOLIMAN_CALIBRATE_H

#include <toliman/fit.h>
#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Result of a calibration. */
typedef struct toliman_calibration toliman_calibration;

/* Flag of options: after the parameters, fit the OPD of each pupil cell. Takes minutes. */
#define TOLIMAN_CALIBRATION_MAP 1u

/* Flag of options: while the model is incomplete, calibrate again with TOLIMAN_CALIBRATION_CHANGE_..., in their order;
 * WINDOWS is first if changes with time explain nearly all of what the model lacks. Changes that reduce the sum of
 * squared residuals by more than noise explains at 6 standard deviations are kept in the fitted scene. */
#define TOLIMAN_CALIBRATION_IMPROVE 2u

/* Flag of options: the default parameters include transfer_smear, interpixel_capacitance and, for frames that are no
 * sums, nonlinearity and brighter_fatter. The relative response of each pixel is also fitted, the same in all frames.
 * The frames distinguish it from the optics because stars move by pixels from frame to frame. With hundreds of frames,
 * separations are as good as with a known detector (promise: detectors-are-calibrated). Free fluxes imitate a common
 * factor and a gradient of the response: only the prior, of mean 1, determines these. */
#define TOLIMAN_CALIBRATION_DETECTOR 4u

/* Changes of a model.
 *   EDGES     telescope.mask.edges = "area", for a spiral mask
 *   SAMPLES   twice as many pupil cells per axis, repeatedly, up to 1024; not with files of the pupil
 *   SPECTRUM  spectrum_a_1, _2, spectrum_b_1, _2 free
 *   WINDOWS   parameters that change with time: window_days of all frames, then half of that, repeatedly; not with the
 *             detector
 *   OPD_MAP   TOLIMAN_CALIBRATION_MAP */
#define TOLIMAN_CALIBRATION_CHANGE_EDGES 2048u
#define TOLIMAN_CALIBRATION_CHANGE_SAMPLES 4096u
#define TOLIMAN_CALIBRATION_CHANGE_SPECTRUM 8192u
#define TOLIMAN_CALIBRATION_CHANGE_WINDOWS 16384u
#define TOLIMAN_CALIBRATION_CHANGE_OPD_MAP 32768u

/* An iteration of a calibration. */
typedef struct toliman_calibration_step {
    uint32_t struct_size;
    int32_t is_map;    /* 1: of the OPD map */
    int32_t iteration; /* from 1 for each change */
    int32_t accepted;  /* 1: accepted */
    double chi_square;
    double largest_step; /* of a parameter, in its standard deviations; with is_response the rms of the response's step
                            in its standard deviations, if that is larger; of the map: rms, nm */
    uint32_t change;     /* TOLIMAN_CALIBRATION_CHANGE_..., or 0 */
    int32_t recalled;    /* 1: from the journal */
    int32_t is_response; /* 1: of the response, and all parameters */
    int32_t reserved;
} toliman_calibration_step;
#define TOLIMAN_CALIBRATION_STEP_INIT TOLIMAN_INIT(toliman_calibration_step)

/* Called after each iteration. so_far has values, no standard deviations, and the flag NOT_CONVERGED; it is valid
 * during the call, and may be saved, to start a later calibration. A nonzero value cancels. */
typedef int32_t (*toliman_calibration_step_fn)(const toliman_calibration *so_far, const toliman_calibration_step *step,
                                               void *user_data);

/* Options of a calibration. */
typedef struct toliman_calibration_options {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_CALIBRATION_MAP, _IMPROVE and _DETECTOR, or 0 */
    /* Parameters to fit, a list of NAME, NAME=SIGMA (of the prior), NAME-LAST: "scale=1e-3 zernike_5-21=50". +NAME: in
     * addition to the default. NULL: all that the scene has of "focus zernike_5-21 scale mask_rotation jitter_xx
     * jitter_yy jitter_xy temperature_a temperature_b spectrum_a_1-2 spectrum_b_1-2". SIGMA by default: aberrations 100
     * nm, scale, anisotropy and shear 1e-2, mask_rotation 1 deg, mask shifts 1e-4 m, jitter 0.1 px^2, temperatures 200
     * K, spectral modes 0.1, diffusion 0.1 px^2, smear and capacitance 1e-2, brighter_fatter and nonlinearity 0.1 over
     * the charge of the brightest pixel. */
    const char *free;
    /* Scene to start from, such as one saved by an interrupted calibration (its mask.edges and pupil_samples are used
     * with IMPROVE only); NULL: the nominal one. Priors are around the nominal one in any case. */
    const toliman_sim *start;
    int32_t most_iterations; /* of the parameters, of the map, of the response, in [1, 1000]; 0 = 30 */
    uint32_t threads;
    double capture_px;  /* as in toliman_fit_options, in [0.1, 64] px; 0 = 6 */
    double window_days; /* length of the windows, in [1e-6, 1e6] days; 0 = constant: no windows */
    double smoothness;  /* standard deviation of changes between windows over prior_sigma, in [1e-9, 1000]; 0 = 0.01 */
    double map_rms_nm;  /* prior rms of the map over the open pupil, in [1e-3, 1e4] nm; 0 = 10 */
    toliman_calibration_step_fn step;
    void *step_data;
    const toliman_allocator *allocator;
    /* File to which each iteration is appended (formats.md, "TLMJ"), 4 KiB per frame, with a map also 8 bytes per cell
     * and step, with a response 8 bytes per pixel and pass over the frames; NULL: none. With an existing journal, the
     * call continues with the bits of an uninterrupted one (promise: journals-continue-calibrations), also with more
     * iterations. The caller removes it once the result is saved. */
    const char *journal;
    double response_rms;          /* prior rms of the relative response, in [1e-6, 0.5]; 0 = 0.01 */
    toliman_progress_fn progress; /* of the parts of an iteration, which take seconds: "derivatives", "frames" ... */
    void *progress_data;
} toliman_calibration_options;
#define TOLIMAN_CALIBRATION_OPTIONS_INIT TOLIMAN_INIT(toliman_calibration_options)

/* Fits the parameters of a scene to `count` frames of image. Without convergence the call succeeds, with
 * TOLIMAN_CALIBRATION_NOT_CONVERGED.
 *   sim          nominal scene
 *   image        in the unit of the scene's frames
 *   predictions  [count]; NULL: times of the scene's frames 0 to count - 1, no shift
 * Errors, in addition to image.h:
 *   - TOLIMAN_E_ARGUMENT for a frame without stars within capture_px; fewer than 2 frames; more than 4096 parameters
 *     times windows; a parameter that is always free;
 *   - TOLIMAN_E_UNSUPPORTED for nonlinearity and brighter_fatter with sums of frames; DETECTOR with window_days, or
 *     with frames read from another part of the detector than detector.window of the scene; a single star; PADDED_FFT;
 *     a named parameter that the scene does not have; position_angle, roll and wavelength;
 *   - TOLIMAN_E_MISMATCH if options->start has other pupil cells, aperture, step of the mask, wavelengths, or shape of
 *     the frames; for a journal of other inputs or options, naming the first that differs
 *     (promise: other-journals-are-refused);
 *   - of a journal, which remains: TOLIMAN_E_FORMAT for another file, TOLIMAN_E_STATE if another process writes to it,
 *     TOLIMAN_E_WRITE if it cannot be written or read. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_create(const toliman_sim *sim,
                                                                         const toliman_image *image, size_t count,
                                                                         const toliman_fit_prediction *predictions,
                                                                         const toliman_calibration_options *options,
                                                                         toliman_calibration **out) TOLIMAN_NOEXCEPT;

/* Destroys a calibration. */
TOLIMAN_API void toliman_calibration_destroy(toliman_calibration *calibration) TOLIMAN_NOEXCEPT;

/* Flag: no maximum was found. Values of a calibration without maximum are NaN (promise: unconverged-values-are-nan). */
#define TOLIMAN_CALIBRATION_NOT_CONVERGED 1u

/* Flag: the frames have an effect that the model lacks (promise: incomplete-models-are-reported): chi_square, of all
 * frames or of a window, is POOR, or structure above structure_limit. */
#define TOLIMAN_CALIBRATION_INCOMPLETE 2u

#define TOLIMAN_CALIBRATION_HELD 4u    /* a parameter is known mostly by its prior */
#define TOLIMAN_CALIBRATION_NO_SIGN 8u /* the sign of even aberrations is undetermined */

/* Flag: chi_square, of all frames or a window, is TOO_GOOD: a wrong read noise, bias, or unit. */
#define TOLIMAN_CALIBRATION_TOO_GOOD 16u

/* Summary of a calibration. */
typedef struct toliman_calibration_info {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_CALIBRATION_...; 0: converged and complete */
    int64_t frames;
    int64_t rows, cols;
    int64_t cells;      /* N: pupil cells per axis */
    int64_t parameters; /* of the instrument, per window */
    int64_t windows;    /* the last one may have no frames */
    int32_t iterations; /* of the parameters, rejected ones included */
    int32_t map_iterations;
    double chi_square; /* goodness.h: pixels minus parameters and map_parameters */
    double chi_square_sigma;
    double structure;            /* sum of squared correlations of neighbouring residuals over their variances;
                                    chi-square distributed with 6 degrees of freedom for white residuals */
    double structure_limit;      /* 50, which white residuals exceed once in 2e8; more with a map */
    double separation_sigma_px;  /* in a frame (median), the instrument known */
    double calibration_sigma_px; /* the same, due to errors of the instrument, map not included; with _DETECTOR that of
                                    the mean separation, response included */
    double map_rms_nm;           /* over the open pupil; 0 without a map */
    double map_parameters;       /* effective number */
    double largest_residual;
    int32_t goodness; /* with a map, the limit of TOO_GOOD is lower */
    uint32_t lacks;   /* with INCOMPLETE: TOLIMAN_CALIBRATION_CHANGE_... that may help */
    uint32_t changes; /* those kept */
    int32_t response_iterations;
    int64_t attempts;
    int64_t left_out;           /* default parameters that the scene does not have */
    double pupil_error;         /* as in toliman_sim_plan_info; above peak_noise, the model may be incomplete */
    double peak_noise;          /* relative photon noise of the brightest pixel in all frames */
    int64_t response_pixels;    /* with a response known better than 0.7 response_rms of the options; others are held by
                                   the prior */
    double response_rms;        /* of the change against the nominal scene, of these pixels */
    double response_parameters; /* number that the frames determine */
} toliman_calibration_info;
#define TOLIMAN_CALIBRATION_INFO_INIT TOLIMAN_INIT(toliman_calibration_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_info(const toliman_calibration *calibration, toliman_calibration_info *out) TOLIMAN_NOEXCEPT;

/* A change of the model that was tried. */
typedef struct toliman_calibration_attempt {
    uint32_t struct_size;
    uint32_t change;
    int32_t kept;   /* 1: later ones build on it */
    uint32_t flags; /* with this change */
    int64_t cells;
    double chi_square;
    double chi_square_sigma, largest_residual;
    int32_t goodness;
    int32_t reserved;
} toliman_calibration_attempt;
#define TOLIMAN_CALIBRATION_ATTEMPT_INIT TOLIMAN_INIT(toliman_calibration_attempt)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_attempt(
    const toliman_calibration *calibration, int64_t index, toliman_calibration_attempt *out) TOLIMAN_NOEXCEPT;

/* A default parameter that was not fitted. */
typedef struct toliman_calibration_left_out {
    uint32_t struct_size;
    uint32_t reserved;
    const char *name;
    const char *reason; /* "needs a spiral mask with mask.edges = "area"" */
} toliman_calibration_left_out;
#define TOLIMAN_CALIBRATION_LEFT_OUT_INIT TOLIMAN_INIT(toliman_calibration_left_out)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_left_out(
    const toliman_calibration *calibration, int64_t index, toliman_calibration_left_out *out) TOLIMAN_NOEXCEPT;

/* Fitted parameter of the instrument. */
typedef struct toliman_calibration_value {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_CALIBRATION_HELD: sigma is above 0.7 prior_sigma; _NO_SIGN: the common sign of all such
                       values is undetermined; the first one is made >= 0 */
    const char *name;
    const char *unit; /* "nm"; "" if relative */
    double value;     /* against the nominal scene, without the map */
    double sigma;     /* all other parameters free */
    double prior_sigma;
} toliman_calibration_value;
#define TOLIMAN_CALIBRATION_VALUE_INIT TOLIMAN_INIT(toliman_calibration_value)

/* Gets a parameter at the start of a window. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_value(const toliman_calibration *calibration, int64_t window, int64_t index,
                              toliman_calibration_value *out) TOLIMAN_NOEXCEPT;

/* Writes the covariance [n][n] of the parameters at the start of a window, those of the frames free. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_covariance(const toliman_calibration *calibration,
                                                                                 int64_t window,
                                                                                 double *covariance) TOLIMAN_NOEXCEPT;

/* Gets the result of frame `index` < frames: that of a fit with the fitted scene; standard deviations include the
 * uncertainty of the instrument. With peak_photons, fluxes are relative to the nominal scene. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_frame(const toliman_calibration *calibration,
                                                                            int64_t index,
                                                                            toliman_fit_result *out) TOLIMAN_NOEXCEPT;

/* Window of a calibration, to the start of the next one. */
typedef struct toliman_calibration_window {
    uint32_t struct_size;
    int32_t goodness;  /* of chi_square */
    int64_t frames;    /* if none, the other members are those of the window before */
    double first_days; /* start, days of scene time, where its parameters hold */
    double chi_square;
    double chi_square_sigma, largest_residual;
} toliman_calibration_window;
#define TOLIMAN_CALIBRATION_WINDOW_INIT TOLIMAN_INIT(toliman_calibration_window)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_window(
    const toliman_calibration *calibration, int64_t window, toliman_calibration_window *out) TOLIMAN_NOEXCEPT;

/* Writes the change of the OPD (m), map included, at the start of a window to opd[N][N]; 0 where the pupil is
 * closed. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_opd(const toliman_calibration *calibration,
                                                                          int64_t window, double *opd) TOLIMAN_NOEXCEPT;

/* Images of a calibration. */
#define TOLIMAN_CALIBRATION_IMAGE_CHI 851    /* mean over frames of squared residual over variance */
#define TOLIMAN_CALIBRATION_IMAGE_BEFORE 852 /* residual of the first frame over its standard deviation, at the start */
#define TOLIMAN_CALIBRATION_IMAGE_AFTER 853  /* at the end */
#define TOLIMAN_CALIBRATION_IMAGE_RESPONSE 854       /* detector.response of the fitted scene */
#define TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA 855 /* standard deviation of response over mean, all parameters free */

/* Writes TOLIMAN_CALIBRATION_IMAGE_... to image[rows][stride]. Residuals of pixels excluded in all frames
 * are 0; their response is that of the prior. RESPONSE and its SIGMA are NaN without TOLIMAN_CALIBRATION_DETECTOR. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_image(const toliman_calibration *calibration,
                                                                            int32_t kind, double *image,
                                                                            size_t stride) TOLIMAN_NOEXCEPT;

/* Saves the fitted scene at the start of a window as `path`, NAME.json, with the verdict in its group `calibration`,
 * and next to it its map as NAME.opd.npy, its response as NAME.response.npy; relative file names are adapted.
 * TOLIMAN_E_UNSUPPORTED without convergence. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_save_file(const toliman_calibration *calibration,
                                                                            int64_t window,
                                                                            const char *path) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
