/* libtoliman, calibrate: parameters of the telescope, learned from frames of the binary itself. The separation that a
 * fit (fit.h) measures is only as accurate as its model of the optics: with 20 nm of unknown aberrations it is wrong by
 * 1e-3 px, in a way that depends on the pointing. The pattern of a mask determines the optics well: after ten
 * frames of 1e12 photons of the shipped mission, their error costs the separation less than 1 % of its standard
 * deviation.
 *
 * Data flow (functions toliman_calibration_...)
 *
 *   toliman_sim (nominal scene), frames, times -> create -> toliman_calibration
 *                                                                   |
 *   values, errors, verdict              get_info, get_value, get_covariance, get_frame
 *   what the model lacks                 get_attempt, get_left_out
 *   images                               get_opd, get_image
 *   fitted scene, for all other uses     save_file, get_window
 *                                        destroy
 *
 * Parameters of the instrument, constant or, with windows, linear in time between the starts of these. They are, as in
 * sim_derivative.h:
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
 * are part of the model. A scene that contradicts its calibration is refused
 * (promise: contradicting-scenes-are-refused). The group also has the verdict, which toliman_sim_info returns and each
 * use logs.
 *
 * A model that lacks an effect, or whose pupil is too coarse, gives separations that are wrong by many standard
 * deviations. The verdict on chi_square (goodness.h) and the correlation of the residuals show it. What may be missing
 * is listed (toliman_calibration_info.lacks), and tried with TOLIMAN_CALIBRATION_IMPROVE.
 */
#ifndef TOLIMAN_CALIBRATE_H
#define TOLIMAN_CALIBRATE_H

#include <toliman/fit.h>
#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Result of a calibration. Several threads may use it at the same time. */
typedef struct toliman_calibration toliman_calibration;

/* Flag of options: fit also the OPD of each pupil cell. */
#define TOLIMAN_CALIBRATION_MAP 1u

/* Flag of options: while the model is incomplete, calibrate again with the changes TOLIMAN_CALIBRATION_CHANGE_..., in
 * their order, each from the last result. A change is kept if the sum of squared residuals falls by more than noise
 * explains at 6 standard deviations. Stops at the first complete model. With _MAP, the map is fitted after the other
 * changes. The fitted scene contains the changes that were kept. */
#define TOLIMAN_CALIBRATION_IMPROVE 2u

/* Changes of a model, one bit each.
 *   EDGES     telescope.mask.edges = "area" instead of "cell", for a spiral mask
 *   SAMPLES   twice as many pupil cells per axis, as often as it helps, up to 1024: where the expected error of the
 *             cells (toliman_sim_plan_info.pupil_error) exceeds the photon noise. Not with files of the pupil, whose
 *             cells are those of the scene
 *   SPECTRUM  spectrum_a_1, _2, spectrum_b_1 and _2 free: slope and curvature of the spectra
 *   OPD_MAP   the OPD of each pupil cell: TOLIMAN_CALIBRATION_MAP */
#define TOLIMAN_CALIBRATION_CHANGE_EDGES 4096u
#define TOLIMAN_CALIBRATION_CHANGE_SAMPLES 8192u
#define TOLIMAN_CALIBRATION_CHANGE_SPECTRUM 16384u
#define TOLIMAN_CALIBRATION_CHANGE_OPD_MAP 32768u

/* An iteration of a calibration. */
typedef struct toliman_calibration_step {
    uint32_t struct_size;
    int32_t is_map;      /* 1: of the OPD map; 0: of the parameters */
    int32_t iteration;   /* 1, 2, ...; the numbers continue from the parameters to the map */
    int32_t accepted;    /* 1: the step was accepted; 0: it was rejected */
    double chi_square;   /* sum of squared residuals over their variances, per degree of freedom */
    double largest_step; /* of a parameter of the instrument, in its standard deviations; of the map: rms in nm */
    uint32_t change;     /* TOLIMAN_CALIBRATION_CHANGE_... that is tried, 0 for the model as given. The numbers of the
                            iterations begin with each change */
    int32_t recalled;    /* 1: the iteration of an earlier call, from the journal */
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
    uint32_t flags;           /* TOLIMAN_CALIBRATION_MAP and _IMPROVE, or 0 */
    const char *free;         /* list of the parameters to fit: NAME, NAME=SIGMA or NAME-LAST, such as "scale=1e-3
                         focus zernike_5-21=50 mask_rotation", with the standard deviation of the prior in the
                         parameter's unit. NULL: all that the scene has of "focus zernike_5-21 scale mask_rotation
                         jitter_xx jitter_yy jitter_xy temperature_a temperature_b spectrum_a_1-2 spectrum_b_1-2".
                         +NAME: these and NAME, or NAME with another prior, such as "+anisotropy +scale=1e-4". Priors
                         without SIGMA: aberrations 100 nm, scale, anisotropy and shear 1e-2, mask_rotation 1 deg, mask
                         shifts 1e-4 m, jitter 0.1 px^2, temperatures 200 K, spectral modes 0.1 */
    const toliman_sim *start; /* scene to start from, such as the saved one of a calibration that was interrupted;
                                 NULL: the nominal scene. Priors remain around the nominal scene. With IMPROVE, its
                                 mask.edges and pupil_samples replace those of the nominal scene */
    int32_t most_iterations;  /* of the parameters, and again of the map, in [1, 1000]; 0 = 30 */
    uint32_t threads;         /* worker threads, 0 = one per processor */
    double
        capture_px; /* largest shift of both stars from their predicted places along x or y, in [0.1, 64] px; 0 = 6 */
    double
        window_days; /* length of the windows, in [1e-6, 1e6] days; 0 = constant: parameters change linearly from the start of one to
                                 that of the next, as images do (toliman_fit_create) */
    double smoothness; /* with windows: standard deviation of the change of each parameter from one start to
                                 the next, in units of prior_sigma, in [1e-9, 1000]; 0 = 0.01 */
    double
        map_rms_nm; /* prior of the map: its rms over the open pupil, in [1e-3, 1e4] nm; 0 = 10. Its power spectrum falls
                                 as frequency^-2.5 above 4 cycles per aperture, and is constant below */
    toliman_calibration_step_fn step; /* may be NULL */
    void *step_data;
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    const char
        *journal; /* file to which the results of each iteration are appended; NULL: none. With an existing journal, the
                            call continues with the bits of an uninterrupted one
                            (promise: journals-continue-calibrations), also with more iterations. It needs 4 KiB per
                            frame and iteration, with a map also 8 bytes per cell and step. The caller removes it once
                            the result is saved. formats.md, "TLMJ" */
} toliman_calibration_options;
#define TOLIMAN_CALIBRATION_OPTIONS_INIT TOLIMAN_INIT(toliman_calibration_options)

/* Creates a calibration of a scene: fits its parameters to `count` frames of image. The caller destroys *out.
 *   sim          nominal scene, not needed afterwards
 *   image        frames in the unit of the scene's frames (photons, electrons or DN); variances are those of the
 *                scene's detector and noise
 *   predictions  [count], times and expected places of the stars; NULL: times of the scene's frames 0 to count - 1, no
 *                shift
 *   options      may be NULL
 * Memory: the frames, plus an amount almost independent of their number. Without convergence the call succeeds, with
 * TOLIMAN_CALIBRATION_NOT_CONVERGED.
 * Errors:
 *   - TOLIMAN_E_ARGUMENT for a count that is not finite, naming its frame, row and column; for frames that do not have
 *     the scene's shape; for a parameter that is unknown, named twice, or always free; for a frame whose stars are not
 *     found within capture_px; for fewer than 2 frames; for more than 4096 parameters times windows;
 *   - TOLIMAN_E_UNSUPPORTED for a single star; with PADDED_FFT; for a parameter that was named and that the scene does
 *     not have; for position_angle, roll and wavelength;
 *   - TOLIMAN_E_MISMATCH if options->start has other pupil cells, aperture, step of the mask, wavelengths, or shape of
 *     the frames than the nominal scene. Nothing else of it is compared;
 *   - TOLIMAN_E_MISMATCH for the journal of a calibration of another scene or other frames, with other free parameters,
 *     options or another start; the message names the first that differs (promise: other-journals-are-refused);
 *   - TOLIMAN_E_FORMAT for any other file, TOLIMAN_E_STATE if another process writes to the journal, TOLIMAN_E_WRITE if
 *     it cannot be written or read: what it holds remains;
 *   - TOLIMAN_E_CANCELLED if step returned a nonzero value. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_create(const toliman_sim *sim,
                                                                         const toliman_image *image, size_t count,
                                                                         const toliman_fit_prediction *predictions,
                                                                         const toliman_calibration_options *options,
                                                                         toliman_calibration **out) TOLIMAN_NOEXCEPT;

/* Destroys a calibration. NULL is allowed. */
TOLIMAN_API void toliman_calibration_destroy(toliman_calibration *calibration) TOLIMAN_NOEXCEPT;

/* Flag: no maximum was found. Values of a calibration without maximum are NaN (promise: unconverged-values-are-nan). */
#define TOLIMAN_CALIBRATION_NOT_CONVERGED 1u

/* Flag of frames with an effect that the model lacks (promise: incomplete-models-are-reported): chi_square, of all
 * frames or of those of a window, is POOR (goodness.h), or structure is above structure_limit. */
#define TOLIMAN_CALIBRATION_INCOMPLETE 2u

#define TOLIMAN_CALIBRATION_HELD 4u    /* a parameter is known mostly by its prior */
#define TOLIMAN_CALIBRATION_NO_SIGN 8u /* the sign of even aberrations is undetermined */

/* Flag: chi_square, of all frames or of those of a window, is TOO_GOOD: the noise is smaller than that of the scene,
 * for instance with a wrong read noise, a bias that was not subtracted, or counts in another unit. */
#define TOLIMAN_CALIBRATION_TOO_GOOD 16u

/* Summary of a calibration. */
typedef struct toliman_calibration_info {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_info) */
    uint32_t flags;       /* TOLIMAN_CALIBRATION_..., the verdict; 0: converged, and the model is complete */
    int64_t frames;       /* frames that were calibrated */
    int64_t rows, cols;   /* shape of the frames */
    int64_t cells;        /* pupil cells per axis, N */
    int64_t parameters;   /* number of parameters of the instrument, at the start of each window */
    int64_t windows;      /* number of windows; the last one may have no frames: it starts at the end of one that has */
    int32_t iterations;   /* of the parameters, the rejected ones included */
    int32_t map_iterations;
    double chi_square;       /* sum of squared residuals over their variances, per degree of freedom: pixels minus
                                parameters, map_parameters included */
    double chi_square_sigma; /* its standard deviation, if the model is right */
    double structure; /* sum over the neighbours (0,1), (1,0), (1,1), (1,-1), (0,2), (2,0) of the squared correlation of
                         the residuals with those of the neighbour, in units of its variance: for white residuals
                         chi-square distributed with 6 degrees of freedom */
    double structure_limit;      /* 50: exceeded by white residuals once in 2e8 calibrations; with a map, which fits
                                    some of the noise, plus pixels times the square of the part of the noise that it
                                    fits */
    double separation_sigma_px;  /* standard deviation of the separation in a frame (median), all parameters
                                    of the frame free and those of the instrument known */
    double calibration_sigma_px; /* standard deviation of the error that the uncertain parameters of the instrument
                                    cause in the separation of a frame (median); without that of the map */
    double map_rms_nm;           /* rms of the fitted map over the open pupil, nm; 0 without a map */
    double map_parameters;       /* effective number of parameters of the map in one step; 0 without a map */
    double largest_residual;     /* largest |residual| over its standard deviation */
    int32_t goodness;   /* TOLIMAN_GOODNESS_..., of chi_square. The steps of a map together may fit the noise of twice
                           map_parameters: the limit below which chi_square is TOO_GOOD is lowered by this */
    uint32_t lacks;     /* with INCOMPLETE: TOLIMAN_CALIBRATION_CHANGE_... that the model may need */
    uint32_t changes;   /* TOLIMAN_CALIBRATION_CHANGE_... that were kept */
    int32_t reserved;   /* 0 */
    int64_t attempts;   /* number of changes that were tried */
    int64_t left_out;   /* number of default parameters that the scene does not have */
    double pupil_error; /* expected error of the pupil cells, relative to the peak: toliman_sim_plan_info */
    double peak_noise;  /* photon noise of the brightest pixel in all frames together, relative. A larger
                           pupil_error may make the model incomplete */
} toliman_calibration_info;
#define TOLIMAN_CALIBRATION_INFO_INIT TOLIMAN_INIT(toliman_calibration_info)

/* Writes the summary of a calibration to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_info(const toliman_calibration *calibration, toliman_calibration_info *out) TOLIMAN_NOEXCEPT;

/* A change of the model that was tried. */
typedef struct toliman_calibration_attempt {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_attempt) */
    uint32_t change;      /* TOLIMAN_CALIBRATION_CHANGE_... */
    int32_t kept;         /* 1: the change was kept, and later ones build on it */
    uint32_t flags;       /* TOLIMAN_CALIBRATION_..., the verdict with this change */
    int64_t cells;        /* pupil cells per axis */
    double chi_square;    /* as in toliman_calibration_info, with this change */
    double chi_square_sigma, largest_residual;
    int32_t goodness;
    int32_t reserved; /* 0 */
} toliman_calibration_attempt;
#define TOLIMAN_CALIBRATION_ATTEMPT_INIT TOLIMAN_INIT(toliman_calibration_attempt)

/* Writes attempt number `index` to *out, whose struct_size must be set. TOLIMAN_E_RANGE unless 0 <= index <
 * attempts. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_attempt(
    const toliman_calibration *calibration, int64_t index, toliman_calibration_attempt *out) TOLIMAN_NOEXCEPT;

/* A default parameter that was not fitted, as the scene does not have it. */
typedef struct toliman_calibration_left_out {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_left_out) */
    uint32_t reserved;    /* 0 */
    const char *name;     /* such as "mask_rotation"; static text */
    const char *reason;   /* such as "needs a spiral mask with mask.edges = "area""; static text */
} toliman_calibration_left_out;
#define TOLIMAN_CALIBRATION_LEFT_OUT_INIT TOLIMAN_INIT(toliman_calibration_left_out)

/* Writes number `index` of the parameters that were left out to *out, whose struct_size must be set. TOLIMAN_E_RANGE
 * unless 0 <= index < left_out. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_left_out(
    const toliman_calibration *calibration, int64_t index, toliman_calibration_left_out *out) TOLIMAN_NOEXCEPT;

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

/* Writes parameter number `index` at the start of a window to *out, whose struct_size must be set. TOLIMAN_E_RANGE
 * unless 0 <= index < parameters and 0 <= window < windows. With a map, the values exclude the map, which adds to their
 * aberrations. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_calibration_get_value(const toliman_calibration *calibration, int64_t window, int64_t index,
                              toliman_calibration_value *out) TOLIMAN_NOEXCEPT;

/* Writes the covariance of the parameters at the start of a window, with those of the frames free, to covariance[n][n];
 * n is the number of parameters. TOLIMAN_E_RANGE as for toliman_calibration_get_value. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_covariance(const toliman_calibration *calibration,
                                                                                 int64_t window,
                                                                                 double *covariance) TOLIMAN_NOEXCEPT;

/* Writes the parameters of frame number `index`, 0 <= index < frames, to *out, whose struct_size must be set: as
 * toliman_fit_frame with the fitted scene, where the standard deviations include the uncertainty of the instrument. A
 * scene with cadence.peak_photons gives its own peak that number of photons: fluxes are then relative to the nominal
 * scene. TOLIMAN_E_RANGE for any other index. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_frame(const toliman_calibration *calibration,
                                                                            int64_t index,
                                                                            toliman_fit_result *out) TOLIMAN_NOEXCEPT;

/* A window of a calibration: first_days <= time < first_days of the next window. Its parameters are those at
 * first_days. */
typedef struct toliman_calibration_window {
    uint32_t struct_size; /* in: sizeof(toliman_calibration_window) */
    int32_t goodness;     /* TOLIMAN_GOODNESS_..., of chi_square */
    int64_t frames;       /* number of its frames; 0: the other members are those of the window before */
    double first_days;    /* start, days of scene time. Before the first start and after the last one, the parameters
                             are constant */
    double chi_square;    /* of its frames, per degree of freedom */
    double chi_square_sigma, largest_residual; /* as in toliman_calibration_info */
} toliman_calibration_window;
#define TOLIMAN_CALIBRATION_WINDOW_INIT TOLIMAN_INIT(toliman_calibration_window)

/* Writes window number `window` to *out, whose struct_size must be set. TOLIMAN_E_RANGE unless 0 <= window < windows.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_window(
    const toliman_calibration *calibration, int64_t window, toliman_calibration_window *out) TOLIMAN_NOEXCEPT;

/* Writes the change of the OPD (m) against the nominal scene at the start of a window, parameters and map together, to
 * opd[N][N]; 0 where the pupil is closed. TOLIMAN_E_RANGE as for toliman_calibration_get_window. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_opd(const toliman_calibration *calibration,
                                                                          int64_t window, double *opd) TOLIMAN_NOEXCEPT;

/* Images of a calibration. */
#define TOLIMAN_CALIBRATION_IMAGE_CHI 851    /* mean over all frames of the squared residual over its variance */
#define TOLIMAN_CALIBRATION_IMAGE_BEFORE 852 /* residual of the first frame over its standard deviation, at the start */
#define TOLIMAN_CALIBRATION_IMAGE_AFTER 853  /* the same at the fitted values */

/* Writes the image TOLIMAN_CALIBRATION_IMAGE_... given by kind to image[rows][stride]; stride >= cols, in elements.
 * Pixels that were excluded in all frames are 0. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_get_image(const toliman_calibration *calibration,
                                                                            int32_t kind, double *image,
                                                                            size_t stride) TOLIMAN_NOEXCEPT;

/* Saves the fitted scene at the start of a window at `path`, a name that ends in ".json", and its map, if there is one,
 * in the same folder as <name>.opd.npy. Relative file names are rewritten relative to this folder. Replaces the files
 * atomically. TOLIMAN_E_UNSUPPORTED if the calibration did not converge; TOLIMAN_E_RANGE for another window;
 * TOLIMAN_E_WRITE. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_calibration_save_file(const toliman_calibration *calibration,
                                                                            int64_t window,
                                                                            const char *path) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
