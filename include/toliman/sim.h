/* libtoliman, simulator: from a scene file to expected images, noisy frames and their Cramer-Rao bounds.
 *
 * Data flow (functions toliman_sim_...)
 *
 *   scene.json -> plan_file, plan_json                               requirements and cost, without images
 *   scene.json -> create_file, create_json -> toliman_sim -> frame -> counts[count][rows][cols]
 *                                             |                   -> cae.h, linear.h, components.h
 *                                             +-> get_info, get_plan, get_stages             properties
 *                                             +-> get_bounds                                 Cramer-Rao bounds
 *                                             +-> get_series, get_offsets                    true values
 *                                             +-> get_pupil, get_spectrum                    optics and light
 *                                             +-> expect, propagate, get_image               images, derivatives
 *                                             +-> sim_derivative.h                           all derivatives
 *                                          destroy
 *
 * Conventions
 *
 *   Arrays       C order, [row][column] = [y][x]. Row 0 and column 0 have the most negative coordinates.
 *
 *   Detector     The centre of pixel j is u_j = (j - (n-1)/2) p, where p is the pixel scale and n the number of
 *                pixels. For even n, the optical axis is the corner shared by the four middle pixels. Offsets are in
 *                pixels from the axis: +x towards higher columns, +y towards higher rows. The rotation of the
 *                detector is the position angle, from north through east, to which its +y axis points. With
 *                scale_anisotropy a and shear s of the scene, an angle (u, v) in units of p is at the pixels
 *                x = (1 + a) u, y = s u + (1 - a) v, and a pixel covers a parallelogram. Displacements, shifts, roll,
 *                scale and jitter are in pixels.
 *
 *   Pupil        Sample i is the centre of a cell at x_i = (i - (N-1)/2) D/N, where D is the aperture diameter and N
 *                the number of pupil samples. Amplitude A = open fraction of the cell times the transmission t of the
 *                amplitude file (1 without a file), in 0..1. Optical path difference OPD = phase mask + Zernike
 *                polynomials + OPD file. The polynomials are in Noll's order, with coefficients in rms over the full
 *                circle; they apply where A > 0. A spiral mask gives each cell the transmission averaged over it,
 *                1 - c + c exp(2 pi i s/lambda), where c is the covered fraction of the cell and s the step
 *                (telescope.mask.edges "area", the default), or, with "cell", the step of its centre. The image is a
 *                smooth function of rotation and shift of the mask; with "cell" it is a staircase. The mask is rotated
 *                about its centre from +x towards +y, then shifted.
 *
 *   Signs        Pupil field E = A exp(+2 pi i OPD/lambda); image field
 *                F(u,v) = sum E exp(-2 pi i (x u + y v)/lambda). A star at offset (+ox, +oy) px has OPD
 *                +(x ox + y oy) p. Its image is at a higher column and row.
 *
 *   Angle        Position angle of B as seen from A, from north through east. Without rotation of the detector, north
 *                is +y and east is -x.
 *
 *   Separation   A positive displacement increases the separation: the star named by signal.star moves away from the
 *                other one. A single star moves towards higher columns.
 *
 *   Intensity    A pixel receives the fraction |F|^2 (D/N p/lambda)^2 / sum(A t) of the light that passes the pupil.
 *                (A contains one factor t. Therefore A t is the open fraction of a cell times t^2: the intensity that
 *                it transmits.) The fractions sum to 1 over an infinite image, apart from the sampling of the pupil
 *                edge. Light that the amplitude file absorbs is not counted: t = 1/2 everywhere changes nothing.
 *                photons_per_s and peak_photons of a scene count detected photons, or, with qe, photons that arrive
 *                at the detector. Light outside the frame is lost.
 *
 *   Spectrum     Wavelengths in uniform steps, both ends with half weight (trapezoidal rule). A single wavelength and
 *                spectral lines are used as given. Fluxes of a scene are those over the band: temperatures and modes
 *                of a spectrum change its shape only.
 *
 *   Pixel        "point": intensity at the centre of the pixel. "integrated": mean intensity over the square pixel.
 *
 *   Time         The time of a frame is the middle of its exposure. binary.date is time 0: an orbit gives the positions
 *                of the stars at that time, with binary.moving at that of each frame. With binary.observer, they are at
 *                their apparent positions (sky.h), averaged over the exposure or over cadence.on_target_s, and
 *                binary.date is a Julian year of TT. Everything that describes the scene as a whole (get_image, bounds,
 *                propagate, expect, and estimators created from the scene) refers to time 0 on the orbit.
 *
 *   Planet       A planet displaces its star by alpha (r/a) sin(true anomaly + argument) along the axis of the
 *                binary, where alpha = a m/(M + m) is the semi-major axis of the star's orbit. Inclination and node
 *                are not modelled: the plane of the orbit contains the axis of the binary and the line of sight. With
 *                zero eccentricity and argument 0 the displacement is a sine of phase phase_rad, the mean anomaly at
 *                time 0. The mean displacement over an eccentric orbit is -3/2 e sin(argument) amplitudes, not 0. The
 *                period follows from Kepler's third law with mass M + m: 365.2569 days for 1 au about 1 solar mass.
 *                Dates and periods of the binary are in years of 365.25 days.
 *
 *   Accuracy     The accuracy of a scene is the largest error of a pixel, relative to the peak of the image
 *                (promise: images-keep-their-accuracy); for the Taylor expansion, relative to the largest change of a
 *                pixel by the signal. It sets the number of wavelengths that are propagated (Chebyshev nodes in
 *                1/lambda, between which the image is interpolated), the order of the Taylor expansion in the
 *                displacement, the interpolation of moving stars, and the pixel integration (see
 *                toliman_sim_plan_file). Below 1e-14, every wavelength is propagated, in every frame of moving stars.
 *                The pupil is sampled as the scene says.
 *
 *   Stages       The detector stages act in this order, each only if the scene names it: expected photons x qe x
 *                pixel response + dark current -> Poisson noise -> full well -> + read noise -> / gain + bias ->
 *                rounding to integer DN, ties to even, clipped to 0 ... 2^bit_depth - 1. A frame is the sum of
 *                `coadds` exposures: the full well and the variance of the read noise are multiplied by coadds;
 *                exposure_s is the total time of these exposures. Pixel responses are 1 + flat_rms times normal
 *                variates of the scene's own seed, the same in every frame. Expected images and bounds include them.
 *
 *   Unit         Unit of frames and expected images: photons; electrons with qe; DN with gain, bias or bit depth.
 *
 *   Systematics  Each systematic of frame k is its rms times a normal variate of (seed, k), plus its drift times the
 *                time of the frame. After the last frame of the cadence, drifts restart. Pointing shifts both stars,
 *                in x and y independently. Roll rotates the star positions about the frame centre from x towards y,
 *                without rotating their diffraction patterns. Scale stretches the whole image about the centre. Focus
 *                is defocus (Noll's fourth Zernike polynomial, nm rms over the full aperture). The fluxes of the
 *                stars vary independently. x and y share one drift, and so do the two fluxes. Background is uniform
 *                light, photons per pixel before qe. Jitter is a Gaussian blur, the same in every frame, with a sigma
 *                or with its covariance in x and y.
 *
 *   Nuisances    Parameters of the model that an estimator does not assume to be known, each with a derivative image;
 *                sim_derivative.h defines them. preprocess.project of the scene lists those that estimators remove
 *                (project out), at most 32. Images that are combinations of those before them are dropped; the
 *                log of an estimator's options receives a warning (see toliman_cae_create).
 *
 *   Engines      The matrix Fourier transform (MATRIX_DFT) samples exact pixel positions. The padded FFT (PADDED_FFT)
 *                is the baseline of the chapter: the pupil is sampled with N_E = N_out p D/lambda points and padded
 *                with zeros to N_out, the smallest power of two that is at least 4 times the longer side of the
 *                frame. N_E is rounded, so each wavelength has a different plate scale. The padded FFT is used only
 *                if requested.
 */
#ifndef TOLIMAN_SIM_H
#define TOLIMAN_SIM_H

#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Simulator: a prepared scene. Each image is computed once, and only if it is needed: the images of the stars when the
 * simulator is created, derivatives and Cramer-Rao bounds by the first call that uses them; TOLIMAN_E_SCENE from such
 * a call if the signal moves a star without changing any pixel of the frame. Frames are then drawn by random access. */
typedef struct toliman_sim toliman_sim;

/* Engines: how light is propagated from the pupil to the detector. See Engines above. */
#define TOLIMAN_SIM_ENGINE_MATRIX_DFT 331 /* exact pixel positions; the default */
#define TOLIMAN_SIM_ENGINE_PADDED_FFT 332 /* baseline of the chapter; no mask, amplitude or OPD files */

/* Options of a simulator. */
typedef struct toliman_sim_options {
    uint32_t struct_size;
    uint32_t threads;             /* worker threads, 0 = one per processor */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    toliman_log_fn log; /* receives warnings about the scene; may be NULL */
    void *log_data;
    int32_t engine; /* TOLIMAN_SIM_ENGINE_..., 0 = MATRIX_DFT */
    int32_t reserved;
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    const char *bad_pixels;             /* file that replaces detector.bad_pixels of the scene; NULL: none does */
} toliman_sim_options;
#define TOLIMAN_SIM_OPTIONS_INIT TOLIMAN_INIT(toliman_sim_options)

/* Creates a simulator from the scene file at path (schema toliman-scene/1). Names of shipped scenes are not
 * recognised: give their path. File names in the scene are relative to its folder. options may be NULL. The caller
 * destroys *out.
 * Errors: TOLIMAN_E_NOT_FOUND and _FORMAT for the scene file or a file that it names, _SCENE for impossible values,
 * _UNSUPPORTED, _CANCELLED. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_file(const char *path,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Creates a simulator from a scene in memory, JSON text of `size` bytes. File names in the scene are relative to
 * folder; NULL = the current directory. Otherwise as toliman_sim_create_file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_json(const char *json, size_t size, const char *folder,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Destroys a simulator. NULL is allowed. */
TOLIMAN_API void toliman_sim_destroy(toliman_sim *sim) TOLIMAN_NOEXCEPT;

/* Units of frames and expected images. See Unit above. */
#define TOLIMAN_SIM_UNIT_PHOTON 301
#define TOLIMAN_SIM_UNIT_ELECTRON 302
#define TOLIMAN_SIM_UNIT_DN 303

/* Verdict of the calibration of a scene (calibrate.h). Estimators that use an INCOMPLETE one may be wrong: logged. */
#define TOLIMAN_SIM_CALIBRATION_NONE 351       /* no calibration fitted the scene, or its file has no verdict */
#define TOLIMAN_SIM_CALIBRATION_COMPLETE 352   /* the model explained the frames of the calibration */
#define TOLIMAN_SIM_CALIBRATION_INCOMPLETE 353 /* it did not, or the calibration did not end */
/* Properties of a prepared scene. */
typedef struct toliman_sim_info {
    uint32_t struct_size;  /* in: sizeof(toliman_sim_info) */
    int32_t wavelengths;   /* number of wavelengths of the spectrum */
    int64_t rows, cols;    /* shape of a frame */
    int64_t frames;        /* number of frames of the cadence */
    int64_t pupil_samples; /* N: the pupil has N x N samples */
    uint64_t seed;         /* noise.seed of the scene */
    double amplitude_px;   /* amplitude of the signal, 0 without one; for a planet, that of the star's orbit */
    double period_days;    /* period of the signal; 0 without one */
    double separation_px;  /* separation of the stars; 0 for a single star */
    double flux_ratio;     /* photons of A / photons of B; 0 for a single star */
    double peak_photons;   /* brightest pixel of the expected frame, before the detector */
    double total_photons;  /* sum over the frame, before the detector */
    double min_displacement_px, max_displacement_px; /* range of the signal over the cadence */
    double amplitude_uas;                            /* amplitude of the signal on the sky, microarcseconds */
    double aperture_m;                               /* diameter of the aperture */
    double pixel_scale_arcsec;                       /* size of a detector pixel on the sky */
    uint64_t scene_digest;        /* FNV-1a hash of the scene text, also stored in weights trained on the scene */
    int32_t whole_counts;         /* 1 if counts are integers (photon noise only, or a bit depth), else 0 */
    int32_t reserved;             /* 0 */
    double peak_counts;           /* brightest pixel of the expected frame, in its unit */
    int32_t unit;                 /* TOLIMAN_SIM_UNIT_..., of frames and expected images */
    int32_t bit_depth;            /* bits per pixel of the detector; 0 = counts are not rounded */
    double exposure_s;            /* length of an exposure; 0 if the scene has peak_photons instead */
    int64_t time_zero_ns;         /* TAI of binary.date of moving stars, ns since 1970-01-01T00:00:00 TAI; else 0 */
    int32_t calibration;          /* TOLIMAN_SIM_CALIBRATION_... */
    int32_t calibration_goodness; /* TOLIMAN_GOODNESS_..., of its chi_square; UNKNOWN without a verdict */
    double calibration_chi_square, calibration_chi_square_sigma; /* NaN without a verdict */
    int64_t bad_pixels; /* pixels of detector.bad_pixels, which no estimator uses */
    const char *name;   /* of the scene; valid until the simulator is destroyed */
} toliman_sim_info;
#define TOLIMAN_SIM_INFO_INIT TOLIMAN_INIT(toliman_sim_info)

/* Writes the properties of the scene to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_info(const toliman_sim *sim,
                                                                   toliman_sim_info *out) TOLIMAN_NOEXCEPT;

/* Cramer-Rao bounds of a frame: the smallest standard deviation of the separation, in px, that an unbiased estimator
 * can reach from a frame; infinite if the frame does not constrain it. Computed from images of accuracy 1e-9 at least,
 * as few wavelengths would underestimate the correlations of nuisances. */
typedef struct toliman_sim_bounds {
    uint32_t struct_size;     /* in: sizeof(toliman_sim_bounds) */
    uint32_t reserved;        /* 0 */
    double crb_px;            /* with all else known; finite if the scene has a signal */
    double crb_flux_shift_px; /* with both fluxes and the common shift unknown */
    double crb_marginal_px;   /* with fluxes, shift, roll, scale, focus and background unknown */
    double crb_projected_px;  /* with those of preprocess.project unknown: reference of an estimator's efficiency */
    double truncation;        /* largest error of the Taylor expansion over the largest change by the signal */
    /* How a mask spreads the light, of the expected frame before the detector. */
    double peak_to_mean;    /* brightest pixel over mean pixel: the dynamic range that the frame needs */
    double gradient_energy; /* mean |gradient of the light|^2 over (mean light)^2, px^-2: fine structure of the frame */
} toliman_sim_bounds;
#define TOLIMAN_SIM_BOUNDS_INIT TOLIMAN_INIT(toliman_sim_bounds)

/* Writes the bounds of the scene to *out, whose struct_size must be set. The first call computes the derivatives, which
 * takes a few times as long as toliman_sim_create_file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_bounds(const toliman_sim *sim,
                                                                     toliman_sim_bounds *out) TOLIMAN_NOEXCEPT;

/* Plan of a scene: what the simulator will compute to reach the accuracy of the scene, with the expected error and
 * cost of each choice. Unless noted otherwise, errors are relative: the largest error of any pixel of the expected
 * image, divided by the peak of the image. */
typedef struct toliman_sim_plan_info {
    uint32_t struct_size;       /* in: sizeof(toliman_sim_plan_info) */
    int32_t engine;             /* TOLIMAN_SIM_ENGINE_... */
    int32_t scene_wavelengths;  /* wavelengths of the spectrum of the scene */
    int32_t wavelengths;        /* wavelengths propagated: all, or fewer Chebyshev nodes in 1/lambda */
    int32_t order;              /* order of the Taylor expansion in the displacement */
    int32_t exact_frames;       /* 1: neither expansion nor interpolation serves; every frame is re-propagated */
    int32_t oversampling;       /* point samples per pixel and axis */
    int32_t filter_taps;        /* taps of the filter that integrates over pixels; 0 = no filter */
    int64_t pupil_samples;      /* N: the pupil has N x N samples */
    int64_t stages;             /* bit set of the modelled stages; read it with toliman_sim_get_stages */
    double accuracy;            /* accuracy that the scene requests */
    double pupil_error;         /* error of N samples; not limited by the accuracy, as the scene sets N */
    double spectrum_error;      /* error of the Chebyshev nodes; 0 if every wavelength is propagated */
    double series_error;        /* error of the Taylor expansion, defined as toliman_sim_bounds.truncation */
    double pixel_error;         /* error of the pixel integration */
    double plate_scale_error;   /* largest relative plate-scale error of the padded FFT; 0 for the matrix DFT */
    double rounding_error;      /* error of double precision */
    double setup_flops;         /* floating-point operations of the setup (all images, once) */
    double frame_flops;         /* floating-point operations of each expected frame, without noise */
    double bytes;               /* memory of frames, one in work per worker thread; bounds may take 1.5 times this */
    double setup_s, frame_s;    /* expected seconds on one core of this machine, with noise; a rough guide */
    int64_t atlas_taps;         /* samples per axis that interpolate a pixel, in frames with moving stars; 0 = none */
    double atlas_error;         /* error of this interpolation; of slopes, divided by the largest slope */
    double scale_focus_error;   /* error of the expansions in scale (first order) and focus (second order), for
                                   systematics of 4 sigma */
    int64_t atlas_oversampling; /* samples per pixel and axis that are interpolated; 0 = none */
    double orbit_px;            /* upper limit of the motion of a star along its orbit from time 0 to any frame */
    int64_t bad_pixels;         /* pixels of detector.bad_pixels, which no estimator uses */
    int64_t fft_side;           /* N_out: the padded FFT has N_out x N_out cells; 0 for the matrix DFT */
    int64_t fft_cells[2]; /* N_E = N_out p D/lambda, rounded, at the longest and the shortest wavelength, p in rad */
} toliman_sim_plan_info;
#define TOLIMAN_SIM_PLAN_INFO_INIT TOLIMAN_INIT(toliman_sim_plan_info)

/* Writes the plan of the scene file at path to *out, whose struct_size must be set, without computing images.
 * Arguments, errors and log messages are those of toliman_sim_create_file, with pixels above full well or bit depth
 * counted in a coarse image. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_file(const char *path,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Writes the plan of a scene in memory to *out. Arguments as toliman_sim_create_json, otherwise as
 * toliman_sim_plan_file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_json(const char *json, size_t size, const char *folder,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* A stage: a physical effect that a scene may include. */
typedef struct toliman_sim_stage {
    uint32_t struct_size; /* in, in the first element: sizeof(toliman_sim_stage) */
    int32_t modelled;     /* 1 if the plan models it, else 0 */
    const char *name;     /* "photon noise"; static text */
} toliman_sim_stage;
#define TOLIMAN_SIM_STAGE_INIT TOLIMAN_INIT(toliman_sim_stage)

/* Writes the stages to stages[capacity] and their number to *count. Later versions may append stages.
 * TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_stages(const toliman_sim_plan_info *plan,
                                                                     toliman_sim_stage *stages, size_t capacity,
                                                                     size_t *count) TOLIMAN_NOEXCEPT;

/* Writes the plan of a simulator to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_plan(const toliman_sim *sim,
                                                                   toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Writes the times (days) and true displacements (px) of frames first ... first + count - 1 to arrays of `count`
 * elements. Either array may be NULL. TOLIMAN_E_RANGE if a frame is outside the cadence. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_series(const toliman_sim *sim, int64_t first,
                                                                     size_t count, double *times_days,
                                                                     double *displacements_px) TOLIMAN_NOEXCEPT;

/* Images of a scene: expected images in the unit of the frame, and their derivatives. They include jitter and no
 * other systematics. */
#define TOLIMAN_SIM_IMAGE_BOTH 311       /* expected frame without displacement, including dark current and bias */
#define TOLIMAN_SIM_IMAGE_STAR_A 312     /* light of star A; also the derivative by its relative flux */
#define TOLIMAN_SIM_IMAGE_STAR_B 313     /* light of star B; TOLIMAN_E_ARGUMENT for a single star */
#define TOLIMAN_SIM_IMAGE_SEPARATION 314 /* derivative by the separation, per px */
#define TOLIMAN_SIM_IMAGE_CURVATURE 315  /* second derivative by the separation, per px^2 */
#define TOLIMAN_SIM_IMAGE_SHIFT_X 316    /* derivative by a common shift towards higher columns, per px */
#define TOLIMAN_SIM_IMAGE_SHIFT_Y 317    /* derivative by a common shift towards higher rows, per px */
/* Variance of the counts, in the square of the unit: (expected electrons + coadds read_e^2)/gain^2, also if the scene
 * draws no photon noise, plus 1/12 DN^2 if counts are rounded. The result is at least 1e-12 of the electrons of the
 * brightest pixel, divided by gain^2. */
#define TOLIMAN_SIM_IMAGE_VARIANCE 318
#define TOLIMAN_SIM_IMAGE_ROLL 319       /* derivative by the roll, per rad */
#define TOLIMAN_SIM_IMAGE_SCALE 320      /* derivative by the relative plate scale */
#define TOLIMAN_SIM_IMAGE_FOCUS 321      /* derivative by the defocus, per nm rms */
#define TOLIMAN_SIM_IMAGE_BACKGROUND 322 /* derivative by light that falls equally on every pixel, per photon */

/* Copies the image TOLIMAN_SIM_IMAGE_... given by kind to image[rows][stride]; stride >= cols, in elements.
 * TOLIMAN_E_ARGUMENT for an unknown kind or a smaller stride. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_image(const toliman_sim *sim, int32_t kind, double *image,
                                                                    size_t stride) TOLIMAN_NOEXCEPT;

/* Copies the pupil: amplitude[N][N], in 0..1 with grey edges, and opd_m[N][N], the optical path difference of mask
 * and aberrations in m; in cells that an edge of the mask crosses (mask.edges "area") its mean over the cell. N is
 * toliman_sim_info.pupil_samples. Either array may be NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_pupil(const toliman_sim *sim, double *amplitude,
                                                                    double *opd_m) TOLIMAN_NOEXCEPT;

/* Copies the spectrum.
 *   wavelength_m        [count], in m
 *   weight_a, weight_b  [count], photons per frame of stars A and B over an infinite image; 0 for an absent star
 *   plate_scale_error   [count], factor by which the padded FFT enlarges the image, minus 1:
 *                       p D N_out/(lambda N_E) - 1; 0 for the matrix DFT
 * Each array may be NULL. TOLIMAN_E_ARGUMENT unless count is toliman_sim_info.wavelengths. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_spectrum(const toliman_sim *sim, size_t count,
                                                                       double *wavelength_m, double *weight_a,
                                                                       double *weight_b,
                                                                       double *plate_scale_error) TOLIMAN_NOEXCEPT;

/* Positions of the stars without displacement, in px from the centre of the frame. NaN for an absent star. */
typedef struct toliman_sim_offsets {
    uint32_t struct_size; /* in: sizeof(toliman_sim_offsets) */
    uint32_t reserved;    /* 0 */
    double a_x_px, a_y_px;
    double b_x_px, b_y_px;
} toliman_sim_offsets;
#define TOLIMAN_SIM_OFFSETS_INIT TOLIMAN_INIT(toliman_sim_offsets)

/* Writes the positions of the stars to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_offsets(const toliman_sim *sim,
                                                                      toliman_sim_offsets *out) TOLIMAN_NOEXCEPT;

/* Computes the expected image for a displacement by propagating every wavelength again, without Taylor expansion, to
 * image[rows][stride] in the unit of the frame. Slow and exact: for tests and large displacements. Includes jitter
 * and no other systematics. TOLIMAN_E_RANGE if |displacement_px| > 100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_propagate(const toliman_sim *sim, double displacement_px,
                                                                    double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Computes the expected image for a displacement by the Taylor expansion, as frames of a small signal without
 * systematics and orbit do, to image[rows][stride] in the unit of the frame. Negative light is set to 0. The order is
 * that of the plan, chosen for the signal of the scene, and at least 2. TOLIMAN_E_RANGE if |displacement_px| > 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_expect(const toliman_sim *sim, double displacement_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Simulates frames first ... first + count - 1 to images[count][rows][cols], on the threads of the simulator's options:
 * systematics of (seed, k) for frame k, then detector stages with noise of (seed, k).
 *   displacements_px  [count]: frames may be beyond the cadence; or NULL: frames of the cadence with the scene's own
 *                     signal
 * A frame depends only on (scene, displacement, seed, k), not on threads or order
 * (promise: frames-depend-on-seed-alone). Images agree to 1e-14 of their peak between CPU types
 * (promise: images-agree-between-cpus), so that a rare noisy count may differ. Calls may run at the same time; if the
 * plan has atlas_taps, the first frame computes the samples to be interpolated while the others wait.
 * Errors, after which images may hold some of the frames: TOLIMAN_E_RANGE for a frame below 0 or, without
 * displacements, outside the cadence, if |displacement| > 0.1 px (100 px if the plan has atlas_taps or exact_frames),
 * or if a pixel expects more than 1e12 electrons (photons, without qe). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame(const toliman_sim *sim, const double *displacements_px,
                                                                uint64_t seed, int64_t first, size_t count,
                                                                double *images) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
