/* libtoliman, simulator: from a scene file to expected images, noisy frames and their Cramer-Rao bounds.
 *
 * Data flow (toliman_sim_...)
 *
 *   scene.json -> plan_file, plan_json                               requirements and cost, without images
 *   scene.json -> create_file, create_json -> toliman_sim -> frame -> counts[count][rows][cols]
 *                                             |                   -> cae.h, linear.h, components.h
 *                                             +-> get_info, get_plan, get_stages             properties
 *                                             +-> get_bounds                                 Cramer-Rao bounds
 *                                             +-> get_series, get_offsets                    true values
 *                                             +-> get_pupil, get_spectrum                    optics and light
 *                                             +-> expect, propagate, get_image               images, derivatives
 *                                             |   expected images, of fit.h too -> expose -> counts of moved stars
 *                                             +-> sim_derivative.h                           all derivatives
 *                                          destroy
 *
 * Conventions (the schema describes the keys of a scene)
 *
 * Detector     The centre of pixel j of n is (j - (n-1)/2) p from the optical axis, with the pixel scale p: +x towards
 *              higher columns, +y towards higher rows. Offsets are in px from the axis.
 * Pupil        Cell i of N is centred at (i - (N-1)/2) D/N; D is the aperture diameter. Amplitude A = open fraction of
 *              the cell times the transmission t of the amplitude file (1 without). OPD (optical path difference) =
 *              phase mask + Zernike polynomials (Noll's order, rms over the full circle) + OPD file.
 * Signs        Pupil field E = A exp(+2 pi i OPD/lambda); image field F(u,v) = sum E exp(-2 pi i (x u + y v)/lambda). A
 *              star at (+ox, +oy) px has OPD +(x ox + y oy) p.
 * Angle        Position angle of B as seen from A, from north through east: from +y to -x, unless the detector is
 *              rotated.
 * Separation   A positive displacement moves the star named by signal.star away from the other one, a single star
 *              towards higher columns. A planet moves its star along the axis of the binary; the mean displacement is
 *              not 0 if its orbit is eccentric.
 * Intensity    A pixel receives the fraction |F|^2 (D/N p/lambda)^2 / sum(A t) of the light that passes the pupil;
 *              light outside the frame is lost. Photons that a scene gives are counted before the detector; with
 *              detected_per_s or a file of quantum efficiencies they are electrons.
 * Time         The time of a frame is the middle of its exposure. Time 0 is binary.date, a Julian year; images, bounds
 *              and estimators of a scene refer to it. An orbit gives the positions at time 0, or, with binary.moving,
 *              at each frame. With binary.observer (sky.h) these are apparent positions, averaged over the exposure or
 *              its time on target (cadence.on_target_s, on_target), and the date is in TT.
 * Optics       If focus, Zernike coefficients or scale vary, each frame is propagated with its own optics
 *              (promise: optics-of-frames-are-exact).
 * Sidelobe     With detector.sidelobe, frames show the first order of a grating in the pupil: light of a wavelength is
 *              displaced by (wavelength - centre_nm)/period, as sines of angles. Derivatives by the spectra and
 *              `wavelength` relate the plate scale to wavelengths. MATRIX_DFT only.
 * Accuracy     `accuracy` of a scene is the largest error of a pixel, relative to the peak of the image
 *              (promise: images-keep-their-accuracy); for the Taylor expansion in the displacement, relative to the
 *              largest change of a pixel by the signal. Below 1e-14, every wavelength is propagated; if stars move, in
 *              every frame.
 * Stages       In this order, each only if the scene names it: expected photons x qe x pixel response + dark current ->
 *              Poisson noise -> full well -> + read noise -> / gain + bias -> rounding to integer DN.
 * Unit         Of frames and expected images: photons; electrons with qe or detected_per_s; DN with gain, bias or bit
 *              depth.
 * Systematics  Drifts restart after the last frame of the cadence. Pointing in x and y shares one drift, as do the two
 *              fluxes. With systematics.smear an image is the mean of images displaced along the path
 *              (promise: smear-is-a-mean-of-images).
 * Nuisances    Unknown parameters (sim_derivative.h) that estimators remove (project out): those of preprocess.project,
 *              at most 32.
 * Engines      MATRIX_DFT samples exact pixel positions. PADDED_FFT is the baseline of the chapter: N_out is the
 *              smallest power of two that is at least 4 times the longer side of the frame, and the pupil has N_E =
 *              N_out p D/lambda samples, padded to N_out. N_E is rounded: the plate scale differs per wavelength. */
#ifndef TOLIMAN_SIM_H
#define TOLIMAN_SIM_H

#include <toliman/goodness.h>

TOLIMAN_BEGIN_DECLS

/* Simulator: a prepared scene. The first call that uses derivatives or bounds computes them: TOLIMAN_E_SCENE if the
 * signal changes no pixel. */
typedef struct toliman_sim toliman_sim;

/* Engines. */
#define TOLIMAN_SIM_ENGINE_MATRIX_DFT 331
#define TOLIMAN_SIM_ENGINE_PADDED_FFT 332 /* no mask, amplitude or OPD files */

/* Options of a simulator. */
typedef struct toliman_sim_options {
    uint32_t struct_size;
    uint32_t threads;
    toliman_progress_fn progress;
    void *progress_data;
    toliman_log_fn log;
    void *log_data;
    int32_t engine; /* TOLIMAN_SIM_ENGINE_..., 0 = MATRIX_DFT */
    int32_t reserved;
    const toliman_allocator *allocator;
    const char *bad_pixels; /* replaces detector.bad_pixels of the scene, if not NULL */
} toliman_sim_options;
#define TOLIMAN_SIM_OPTIONS_INIT TOLIMAN_INIT(toliman_sim_options)

/* Creates a simulator from the scene file at path (schema toliman-scene/1). File names in it are relative to its
 * folder.
 * Errors, of the scene file or one that it names: TOLIMAN_E_NOT_FOUND, _FORMAT, _UNSUPPORTED, _SCENE for impossible
 * values. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_file(const char *path,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Creates a simulator from JSON text of `size` bytes; otherwise as toliman_sim_create_file.
 *   folder  of the files that it names; NULL: the current one */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_json(const char *json, size_t size, const char *folder,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Destroys a simulator. */
TOLIMAN_API void toliman_sim_destroy(toliman_sim *sim) TOLIMAN_NOEXCEPT;

/* Units of frames. */
#define TOLIMAN_SIM_UNIT_PHOTON 301
#define TOLIMAN_SIM_UNIT_ELECTRON 302
#define TOLIMAN_SIM_UNIT_DN 303

/* Verdict of the calibration of a scene (calibrate.h). Estimators of an INCOMPLETE scene may be wrong: a warning is
 * logged. */
#define TOLIMAN_SIM_CALIBRATION_NONE 351       /* not calibrated, or no verdict */
#define TOLIMAN_SIM_CALIBRATION_COMPLETE 352   /* the model explained the frames */
#define TOLIMAN_SIM_CALIBRATION_INCOMPLETE 353 /* it did not, or the calibration did not end */
/* Properties of a scene. */
typedef struct toliman_sim_info {
    uint32_t struct_size;
    int32_t wavelengths;
    int64_t rows, cols;
    int64_t frames;
    int64_t pupil_samples; /* N */
    uint64_t seed;
    double amplitude_px;                             /* 0 without a signal; of a planet: of the star's orbit */
    double period_days;                              /* 0 without a signal */
    double separation_px;                            /* 0 for a single star */
    double flux_ratio;                               /* photons of A / photons of B; 0 for a single star */
    double peak_photons;                             /* brightest pixel before the detector */
    double total_photons;                            /* of the frame, before the detector */
    double min_displacement_px, max_displacement_px; /* of the signal over the cadence */
    double amplitude_uas;
    double aperture_m;
    double pixel_scale_arcsec;
    uint64_t scene_digest; /* FNV-1a of the scene text, also in weights */
    int32_t whole_counts;  /* 1 if counts are integers (photon noise only, or a bit depth) */
    int32_t reserved;
    double peak_counts; /* brightest pixel, in the unit of the frame */
    int32_t unit;
    int32_t bit_depth;    /* 0 = counts are not rounded */
    double exposure_s;    /* 0 with peak_photons */
    int64_t time_zero_ns; /* TAI of binary.date; 0 unless stars move */
    int32_t calibration;  /* TOLIMAN_SIM_CALIBRATION_... */
    int32_t calibration_goodness;
    double calibration_chi_square, calibration_chi_square_sigma;
    int64_t bad_pixels; /* of the detector, which no estimator uses */
    const char *name;   /* valid until the simulator is destroyed */
} toliman_sim_info;
#define TOLIMAN_SIM_INFO_INIT TOLIMAN_INIT(toliman_sim_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_info(const toliman_sim *sim,
                                                                   toliman_sim_info *out) TOLIMAN_NOEXCEPT;

/* Cramer-Rao bounds: smallest standard deviations of the separation in one frame that an unbiased estimator can reach;
 * infinite if the frame does not constrain it. */
typedef struct toliman_sim_bounds {
    uint32_t struct_size;
    uint32_t reserved;
    double crb_px;            /* all else known */
    double crb_flux_shift_px; /* fluxes and common shift unknown */
    double crb_marginal_px;   /* also roll, scale, focus and background */
    double crb_projected_px;  /* those of preprocess.project unknown */
    double truncation;        /* error of the Taylor expansion over the largest change by the signal */
    double peak_to_mean;      /* brightest over mean pixel of the expected frame, before the detector */
    double gradient_energy;   /* mean |gradient|^2 of it over mean^2, px^-2 */
} toliman_sim_bounds;
#define TOLIMAN_SIM_BOUNDS_INIT TOLIMAN_INIT(toliman_sim_bounds)

/* Gets the bounds of a scene. The first call computes them. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_bounds(const toliman_sim *sim,
                                                                     toliman_sim_bounds *out) TOLIMAN_NOEXCEPT;

/* Plan: what is computed to reach the accuracy of a scene. Errors are relative to the peak of the expected image. */
typedef struct toliman_sim_plan_info {
    uint32_t struct_size;
    int32_t engine;
    int32_t scene_wavelengths;
    int32_t wavelengths;  /* propagated: all, or fewer Chebyshev nodes in 1/lambda */
    int32_t order;        /* of the Taylor expansion */
    int32_t exact_frames; /* 1: every frame is propagated */
    int32_t oversampling;
    int32_t filter_taps;   /* of the filter over pixels; 0 = none */
    int64_t pupil_samples; /* N */
    int64_t stages;
    double accuracy;
    double pupil_error; /* due to N samples; `accuracy` does not reduce it */
    double spectrum_error;
    double series_error; /* as toliman_sim_bounds.truncation */
    double pixel_error;
    double plate_scale_error; /* of the padded FFT, relative */
    double rounding_error;
    double setup_flops;         /* all images, once */
    double frame_flops;         /* an expected frame, without noise */
    double bytes;               /* with one frame per worker thread; bounds may take 1.5 times this */
    double setup_s, frame_s;    /* rough guide, on one core, with noise */
    int64_t atlas_taps;         /* samples per axis that interpolate a pixel of a moving star; 0 = none */
    double atlas_error;         /* of this interpolation; that of slopes is relative to the largest slope */
    int64_t atlas_oversampling; /* samples per pixel and axis; 0 = none */
    double orbit_px;            /* largest motion along the orbit from time 0 */
    int64_t bad_pixels;
    int64_t fft_side;     /* N_out; 0 for the matrix DFT */
    int64_t fft_cells[2]; /* N_E at the longest and shortest wavelength */
    /* Light of A and B over the band and an infinite image, 0 where the scene does not give it. */
    double open_area_m2;       /* of the pupil */
    double magnitude[2];       /* NaN if not given */
    double throughput[2];      /* mean over the photons of the star */
    double photons_per_s[2];   /* at the focal plane: through the open area, times throughput */
    double electrons_per_s[2]; /* these times the quantum efficiency */
} toliman_sim_plan_info;
#define TOLIMAN_SIM_PLAN_INFO_INIT TOLIMAN_INIT(toliman_sim_plan_info)

/* Gets the plan of a scene file, without images, as toliman_sim_create_file; pixels above full well or bit depth are
 * counted in a coarse image. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_file(const char *path,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Gets the plan of JSON text, as toliman_sim_create_json. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_json(const char *json, size_t size, const char *folder,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Physical effect that a scene may include. */
typedef struct toliman_sim_stage {
    uint32_t struct_size;
    int32_t modelled; /* 1: modelled */
    const char *name;
} toliman_sim_stage;
#define TOLIMAN_SIM_STAGE_INIT TOLIMAN_INIT(toliman_sim_stage)

/* Writes the stages. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_stages(const toliman_sim_plan_info *plan,
                                                                     toliman_sim_stage *stages, size_t capacity,
                                                                     size_t *count) TOLIMAN_NOEXCEPT;

/* Gets the plan of a simulator. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_plan(const toliman_sim *sim,
                                                                   toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Writes times and true displacements of frames first ... first + count - 1 to arrays [count]; either may be NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_series(const toliman_sim *sim, int64_t first,
                                                                     size_t count, double *times_days,
                                                                     double *displacements_px) TOLIMAN_NOEXCEPT;

/* Images of a scene, with jitter and no other systematics: expected ones in the unit of the frame, and derivatives per
 * unit of the parameters of sim_derivative.h. */
#define TOLIMAN_SIM_IMAGE_BOTH 311   /* expected frame without displacement */
#define TOLIMAN_SIM_IMAGE_STAR_A 312 /* light of A, also the derivative by flux_a */
#define TOLIMAN_SIM_IMAGE_STAR_B 313 /* TOLIMAN_E_ARGUMENT for a single star */
#define TOLIMAN_SIM_IMAGE_SEPARATION 314
#define TOLIMAN_SIM_IMAGE_CURVATURE 315 /* second derivative by the separation, per px^2 */
#define TOLIMAN_SIM_IMAGE_SHIFT_X 316
#define TOLIMAN_SIM_IMAGE_SHIFT_Y 317
/* Variance of the counts: (expected electrons + coadds read_e^2)/gain^2, + 1/12 DN^2 if rounded; also without photon
 * noise. */
#define TOLIMAN_SIM_IMAGE_VARIANCE 318
#define TOLIMAN_SIM_IMAGE_ROLL 319
#define TOLIMAN_SIM_IMAGE_SCALE 320
#define TOLIMAN_SIM_IMAGE_FOCUS 321
#define TOLIMAN_SIM_IMAGE_BACKGROUND 322

/* Copies the image TOLIMAN_SIM_IMAGE_... to image[rows][stride]. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_image(const toliman_sim *sim, int32_t kind, double *image,
                                                                    size_t stride) TOLIMAN_NOEXCEPT;

/* Copies amplitude[N][N], 0 to 1, and opd_m[N][N], means over the cells, of the pupil; either may be NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_pupil(const toliman_sim *sim, double *amplitude,
                                                                    double *opd_m) TOLIMAN_NOEXCEPT;

/* Copies the spectrum to arrays [count], count = toliman_sim_info.wavelengths; each may be NULL.
 *   weight_a, weight_b  photons per frame of A and B over an infinite image; 0 for an absent star
 *   plate_scale_error   factor by which the padded FFT enlarges the image, minus 1 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_spectrum(const toliman_sim *sim, size_t count,
                                                                       double *wavelength_m, double *weight_a,
                                                                       double *weight_b,
                                                                       double *plate_scale_error) TOLIMAN_NOEXCEPT;

/* Positions of the stars without displacement, from the centre of the frame; NaN for an absent star. */
typedef struct toliman_sim_offsets {
    uint32_t struct_size;
    uint32_t reserved;
    double a_x_px, a_y_px;
    double b_x_px, b_y_px;
} toliman_sim_offsets;
#define TOLIMAN_SIM_OFFSETS_INIT TOLIMAN_INIT(toliman_sim_offsets)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_offsets(const toliman_sim *sim,
                                                                      toliman_sim_offsets *out) TOLIMAN_NOEXCEPT;

/* Computes the expected image for a displacement to image[rows][stride] by propagation (slow), with jitter and no other
 * systematics. TOLIMAN_E_RANGE if |displacement_px| > 100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_propagate(const toliman_sim *sim, double displacement_px,
                                                                    double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Computes the same by the Taylor expansion, without an orbit: of the plan's order, at least 2; negative light is set
 * to 0. TOLIMAN_E_RANGE if |displacement_px| > 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_expect(const toliman_sim *sim, double displacement_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Simulates frames first ... first + count - 1 to images[count][rows][cols].
 *   displacements_px  [count], also beyond the cadence; NULL: the scene's own signal
 * A frame depends only on (scene, displacement, seed, k), not on threads or order
 * (promise: frames-depend-on-seed-alone). Images agree to 1e-14 of their peak between CPU types
 * (promise: images-agree-between-cpus): a rare noisy count may differ.
 * Errors, after which images may hold some frames: TOLIMAN_E_RANGE for a frame below 0 or, without displacements,
 * outside the cadence; if |displacement| > 0.1 px (100 px if the plan has atlas_taps or exact_frames); if a pixel
 * expects more than 1e12 electrons (photons, without qe). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame(const toliman_sim *sim, const double *displacements_px,
                                                                uint64_t seed, int64_t first, size_t count,
                                                                double *images) TOLIMAN_NOEXCEPT;

/* Adds noise and detector to expected images, as to frames first ... first + count - 1 of toliman_sim_frame: the bits
 * of a frame depend on (expected image, scene, seed, k) only.
 *   expected  [count][rows][cols], in the unit of frames, as toliman_sim_expect and toliman_fit_predict write it.
 *             The caller may have added light or charge of other sources
 *   images    [count][rows][cols], the frames; may be `expected`
 * Errors, after which images may hold some frames: TOLIMAN_E_ARGUMENT for a pixel that is not finite or below the bias;
 * TOLIMAN_E_RANGE for a frame below 0 and for more than 1e12 electrons. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_expose(const toliman_sim *sim, const double *expected,
                                                                 uint64_t seed, int64_t first, size_t count,
                                                                 double *images) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
