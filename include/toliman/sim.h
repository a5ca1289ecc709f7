/* libtoliman, simulator: from a scene file to expected images, noisy frames and what they can tell at best.
 *
 * Data flow (functions toliman_sim_...)
 *
 *   scene.json -> plan_file, plan_json                                what it needs and costs, without its images
 *   scene.json -> create_file, create_json -> toliman_sim -> frame, frame_many -> counts[rows][cols]
 *    options_init                             |                   -> cae.h, linear.h, components.h
 *                                             +-> get_info, get_name, get_plan, get_stage     facts and bounds
 *                                             +-> get_series, get_offsets                         what is true
 *                                             +-> get_pupil, get_spectrum, get_plate_scale        light on its way
 *                                             +-> expect, propagate, get_image    without noise; derivatives
 *                                                 stage_name, image_name          names
 *                                          destroy
 *
 * Conventions
 *   Arrays      C order, [row][column] = [y][x]; row 0 and column 0 are the most negative coordinates.
 *   Pupil       sample i stands at x_i = (i - (N-1)/2) D/N, the cell's centre; D the aperture, N the pupil samples.
 *               Amplitude A = open fraction of the cell times t of the scene's file (1 without one), in 0..1. OPD =
 * mask
 *               + Zernike polynomials (Noll's order, rms over the full aperture; where A > 0) + OPD file.
 *   Detector    pixel j stands at u_j = (j - (n-1)/2) p, p the pixel scale; for even n the axis is the corner of the
 *               four middle pixels. Offsets are given in pixels from there, x to higher columns, y to higher rows. A
 *               rotation is the position angle of the rows' +y axis: a star at that angle stands at +y.
 *   Signs       E = A exp(+2 pi i OPD/lambda), F(u,v) = sum E exp(-2 pi i (x u + y v)/lambda). A star at offset
 *               (+ox, +oy) px has OPD +(x ox + y oy) p and its image stands at higher column and row.
 *   Angle       position angle of B seen from A, from +y towards -x (north up, east left).
 *   Separation  positive displacement lengthens it: star A moves away from B, or B from A. A star alone moves towards
 *               higher columns.
 *   Intensity   fraction of the light through the pupil that falls in a pixel, |F|^2 (D/N p/lambda)^2 / sum(A t): sums
 *               to 1 over an infinite image. What an amplitude file absorbs is not counted: t = 1/2 everywhere changes
 *               nothing, and photons_per_s of a scene are at the detector. Light outside the frame is lost.
 *   Time        of a frame is the middle of its exposure, over which nothing is averaged: stars and signal stand as at
 *               that instant. Light travel time (to the barycentre) is not modelled. binary.date is time 0. With an
 *               orbit the stars stand throughout where they are then; with binary.moving they follow it, and frames
 *               are made about anchors along it. All that describes the scene as one (images, bounds, propagate,
 *               expect, estimators made of it) is that of time 0.
 *   Planet      moves its star by a m/(M + m) r/a sin(true anomaly + argument) along the axis, as if the orbit's plane
 *               held it: argument 0 is a sine of phase_rad, the mean anomaly at time 0. On an eccentric orbit the mean
 *               over a period is not 0 but -3/2 e sin(argument) amplitudes. Its period is Kepler's, with M + m:
 *               365.2569 days for 1 au about 1 solar mass. Dates and periods of the stars' orbit are in years of
 *               365.25 days.
 *   Accuracy    what the scene allows decides how many Chebyshev nodes stand for its wavelengths, how many terms the
 *               series of the displacement has and how pixels are integrated (toliman_sim_plan_file); below 1e-14 every
 *               wavelength is propagated by itself. Pupils are sampled as the scene says, whatever that costs.
 *   Spectrum    uniform steps, both ends at half weight (trapezium); one wavelength or lines as they are.
 *   Pixel       "point": the image at the pixel's centre. "integrated": its mean over the pixel's square.
 *   Stages      of the detector, in this order, each only where the scene names it: expected photons x qe x the
 *               pixel's response + dark current -> Poisson -> full well -> + read noise -> / gain + bias -> rounded to
 *               whole DN, halves to even, and cut to 0 ... 2^bit_depth - 1. With qe, photons_per_s and peak_photons are
 *               those that arrive. A frame is the sum of `coadds` frames: variance of the read noise and full well
 *               times coadds; exposure_s is that of the sum. Responses are 1 + flat_rms times a normal variate of the
 *               scene's own seed, the same in all frames; expected images and bounds know them.
 *   Unit        of frames and expected images: photons; electrons with qe; DN with gain, bias or bit depth.
 *   Systematics of frame k: each is its rms times a normal variate of (seed, k), plus its drift times the frame's time;
 *               after the cadence's last frame the drifts begin anew. Pointing shifts both stars, x and y
 *               independently. Roll turns the stars about the frame's centre from x towards y; their patterns do not
 *               turn. Scale stretches the image, patterns included, about the centre; focus is defocus (Noll's fourth,
 *               nm rms over the full aperture). Fluxes of the stars vary independently. One drift holds for x and y,
 *               and for both stars. Jitter is a Gaussian blur, the same in all frames.
 *   Engines     the matrix DFT has exact pixel positions. The padded FFT is the chapter's: it embeds N_E = N_out p D /
 *               lambda samples in N_out, the power of two from 4 times the frame's longer side; N_E is rounded, so that
 *               each wavelength has its own plate scale. A baseline, chosen only by who asks for it.
 *   Nuisances   shift x, y: both stars, per px. Roll: the stars turn about the frame's centre from x towards y, their
 *               patterns stay, per rad. Scale: the whole image stretches about the frame's centre, relative. Focus:
 *               Noll's fourth Zernike polynomial, per nm rms. Background: the same in every pixel, per photon.
 */
#ifndef TOLIMAN_SIM_H
#define TOLIMAN_SIM_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* A scene made ready: PSFs and derivative images computed once, then frames by random access. Const calls may run on
 * one simulator from several threads. Since 0.1. */
typedef struct toliman_sim toliman_sim;

/* How a simulator is made. Since 0.1. */
typedef struct toliman_sim_options {
    uint32_t struct_size;
    uint32_t threads;             /* own workers; 0 = one a processor. Never changes a bit of any result */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    toliman_log_fn log; /* may be NULL */
    void *log_data;
    int32_t engine; /* TOLIMAN_SIM_ENGINE_..., 0 = MATRIX_DFT */
    int32_t reserved;
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
} toliman_sim_options;
#define TOLIMAN_SIM_OPTIONS_INIT TOLIMAN_INIT(toliman_sim_options)

/* Ways to propagate light: Engines, in the conventions of toliman/sim.h. */
#define TOLIMAN_SIM_ENGINE_MATRIX_DFT 331 /* exact pixel positions */
#define TOLIMAN_SIM_ENGINE_PADDED_FFT 332 /* no mask, amplitude or OPD files */

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_sim_options_init(toliman_sim_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Simulator of the scene file at path (schema toliman-scene/1); relative file names inside it start at its folder.
 * options may be NULL. The caller destroys *out. TOLIMAN_E_NOT_FOUND or _FORMAT for this or a named file, _SCENE for
 * impossible content, _UNSUPPORTED, _CANCELLED, _MEMORY. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_file(const char *path,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* The same from JSON text of `size` bytes in memory; folder is where relative file names start (NULL = the current
 * one). Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_json(const char *json, size_t size, const char *folder,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Ends a simulator; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_sim_destroy(toliman_sim *sim) TOLIMAN_NOEXCEPT;

/* Units of frames and expected images: Unit, in the conventions of toliman/sim.h. */
#define TOLIMAN_SIM_UNIT_PHOTON 301
#define TOLIMAN_SIM_UNIT_ELECTRON 302
#define TOLIMAN_SIM_UNIT_DN 303

/* Facts of a ready scene. Since 0.1. */
typedef struct toliman_sim_info {
    uint32_t struct_size;  /* in: sizeof(toliman_sim_info) */
    int32_t wavelengths;   /* samples of the spectrum */
    int64_t rows, cols;    /* of a frame */
    int64_t frames;        /* of the cadence */
    int64_t pupil_samples; /* N of the N x N pupil */
    uint64_t seed;         /* noise.seed of the scene */
    double amplitude_px;   /* of the signal; 0 without one. A planet's: semi-major axis of its star's orbit */
    double period_days;    /* of the signal; 0 without one */
    double separation_px;  /* 0 for a single star */
    double flux_ratio;     /* photons of A over photons of B; 0 for a single star */
    double peak_photons;   /* brightest pixel of the mean frame, before the detector */
    double total_photons;  /* in the frame, before the detector */
    /* Cramer-Rao bounds of the separation a frame; infinite where the frame tells nothing of it */
    double crb_px;            /* all else known; finite where the scene has a signal */
    double crb_flux_shift_px; /* the same with both fluxes and the common shift unknown */
    double crb_projected_px;  /* the same with exactly preprocess.project unknown; the yardstick of efficiency */
    double truncation;        /* error of the series in the displacement, largest pixel over that of the signal, at the
                                 signal's largest displacement; above the scene's accuracy it is logged as a warning */
    double min_displacement_px, max_displacement_px; /* of the signal over the cadence */
    double amplitude_uas;                            /* amplitude_px on the sky, microarcsec */
    double aperture_m;                               /* diameter */
    double pixel_scale_arcsec;                       /* of a detector pixel */
    uint64_t scene_digest;                           /* FNV-1a of the scene's text, as in the weights trained for it */
    int64_t whole_counts;   /* 1 if frames hold whole numbers (photon noise alone, or a bit depth), else 0 */
    double crb_marginal_px; /* Cramer-Rao bound with all eight nuisances unknown; may be infinite */
    double peak_counts;     /* brightest pixel of the mean frame, in the frame's unit */
    int32_t unit;           /* of frames and expected images: TOLIMAN_SIM_UNIT_PHOTON, _ELECTRON or _DN */
    int32_t bit_depth;      /* of the scene's detector; 0 = counts are not rounded */
} toliman_sim_info;
#define TOLIMAN_SIM_INFO_INIT TOLIMAN_INIT(toliman_sim_info)

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_info(const toliman_sim *sim,
                                                                   toliman_sim_info *out) TOLIMAN_NOEXCEPT;

/* What a scene needs at its accuracy, and what each choice is expected to cost. Errors are max error / peak of the
 * expected image against the scene without that choice; a test holds them against the true ones. Since 0.1. */
typedef struct toliman_sim_plan_info {
    uint32_t struct_size;      /* in: sizeof(toliman_sim_plan_info) */
    int32_t engine;            /* TOLIMAN_SIM_ENGINE_MATRIX_DFT or TOLIMAN_SIM_ENGINE_PADDED_FFT */
    int32_t scene_wavelengths; /* of the spectrum as the scene has it */
    int32_t wavelengths;       /* propagated: as many, or fewer Chebyshev nodes in 1/lambda */
    int32_t order;             /* of the series in the displacement */
    int32_t exact_frames;      /* 1: no series pays, every frame is propagated anew */
    int32_t oversampling;      /* point samples per pixel and axis */
    int32_t filter_taps;       /* of the filter that integrates over pixels; 0 = none */
    int64_t pupil_samples;     /* N of N x N */
    int64_t stages;            /* those that are modelled, for toliman_sim_get_stage alone */
    double accuracy;           /* what the scene asks for */
    double pupil_error;       /* of N samples against a pupil without any; not held to the accuracy, N is the scene's */
    double spectrum_error;    /* of the nodes; 0 when every wavelength is propagated */
    double series_error;      /* of the series, largest pixel over that of the signal, at its largest displacement */
    double pixel_error;       /* of the filter */
    double plate_scale_error; /* relative, of the padded FFT at its worst wavelength; 0 for the matrix DFT */
    double rounding_error;    /* of double precision */
    double setup_flops;       /* all images, once */
    double frame_flops;       /* each expected frame, before its noise */
    double bytes;             /* memory, with as many frames made at a time as there are workers */
    double setup_s, frame_s;  /* on one core of this machine, noise included; a rough guide */
    int64_t place_order;      /* of the series in the places of both stars, for systematics and orbits; 0 = none */
    double place_error;       /* of that series, over the signal's largest pixel, for disturbances of 4 sigma */
    double scale_focus_error; /* of scale to first and focus to second order, for disturbances of 4 sigma */
    int64_t anchors;          /* points of the orbit about which that series is made anew; 0 = at time 0 only */
    double orbit_px; /* that a star moves along its orbit from time 0 to any frame, at most: speed times time */
} toliman_sim_plan_info;
#define TOLIMAN_SIM_PLAN_INFO_INIT TOLIMAN_INIT(toliman_sim_plan_info)

/* The plan of the scene file at path, without making its images; arguments and errors as toliman_sim_create_file, *out
 * as toliman_sim_get_plan. The log hears what it would of toliman_sim_create_file; pixels that meet the full well or
 * the bit depth are counted on a rough image. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_file(const char *path,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* The same of JSON text of `size` bytes in memory, as toliman_sim_create_json takes it. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_plan_json(const char *json, size_t size, const char *folder,
                                                                    const toliman_sim_options *options,
                                                                    toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Returns the name of the stage with the number 0, 1, ... ("photon noise"), NULL behind the last one. Static text; new
 * stages may come. Since 0.2. */
TOLIMAN_API const char *toliman_sim_stage_name(int32_t stage) TOLIMAN_NOEXCEPT;

/* Sets *modelled to 1 if a plan models the stage of that name, else to 0. TOLIMAN_E_ARGUMENT for a name that no stage
 * has. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_stage(const toliman_sim_plan_info *plan, const char *name,
                                                                    int32_t *modelled) TOLIMAN_NOEXCEPT;

/* The plan that a simulator follows; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_plan(const toliman_sim *sim,
                                                                   toliman_sim_plan_info *out) TOLIMAN_NOEXCEPT;

/* Name of the scene; lives as long as sim. "" for NULL. Since 0.1. */
TOLIMAN_API const char *toliman_sim_get_name(const toliman_sim *sim) TOLIMAN_NOEXCEPT;

/* Times (days) and true displacements (px) of frames first ... first + count - 1; either array may be NULL.
 * TOLIMAN_E_RANGE outside the cadence. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_series(const toliman_sim *sim, int64_t first,
                                                                     size_t count, double *times_days,
                                                                     double *displacements_px) TOLIMAN_NOEXCEPT;

/* Expected images in the frame's unit (derivatives: per unit of the quantity), without systematics but jitter. */
#define TOLIMAN_SIM_IMAGE_BOTH 311       /* the whole frame without displacement, with dark current and bias */
#define TOLIMAN_SIM_IMAGE_STAR_A 312     /* also the derivative with respect to the relative flux of A */
#define TOLIMAN_SIM_IMAGE_STAR_B 313     /* TOLIMAN_E_ARGUMENT for a single star */
#define TOLIMAN_SIM_IMAGE_SEPARATION 314 /* d/d separation, per px */
#define TOLIMAN_SIM_IMAGE_CURVATURE 315  /* second derivative, per px^2 */
#define TOLIMAN_SIM_IMAGE_SHIFT_X 316    /* d/d common shift towards higher columns, per px */
#define TOLIMAN_SIM_IMAGE_SHIFT_Y 317    /* d/d common shift towards higher rows, per px */
/* Variance of the counts, in the square of the unit: expected electrons + coadds read_e^2, even where the scene draws
 * no photon noise; 1/12 DN^2 of rounding; at least 1e-12 of the brightest pixel. */
#define TOLIMAN_SIM_IMAGE_VARIANCE 318
#define TOLIMAN_SIM_IMAGE_ROLL 319       /* d/d roll, per rad */
#define TOLIMAN_SIM_IMAGE_SCALE 320      /* d/d relative plate scale */
#define TOLIMAN_SIM_IMAGE_FOCUS 321      /* d/d defocus, per nm rms */
#define TOLIMAN_SIM_IMAGE_BACKGROUND 322 /* d/d light that falls on every pixel alike, per photon */
/* Returns the name of one of them ("shift_x"), "?" for an unknown one. Static text. Since 0.2. */
TOLIMAN_API const char *toliman_sim_image_name(int32_t kind) TOLIMAN_NOEXCEPT;

/* Copies one of them into image[rows][stride], stride >= cols in elements. TOLIMAN_E_ARGUMENT for another kind or a
 * smaller stride. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_image(const toliman_sim *sim, int32_t kind, double *image,
                                                                    size_t stride) TOLIMAN_NOEXCEPT;

/* Pupil of the scene, each [N][N] with N the pupil_samples of the info: amplitude A in 0..1 (grey edges) and OPD in m,
 * of mask and aberrations. Either may be NULL. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_pupil(const toliman_sim *sim, double *amplitude,
                                                                    double *opd_m) TOLIMAN_NOEXCEPT;

/* Spectrum as used: wavelengths (m) and photon weights of A and B a frame (whole star, before cropping); count must be
 * `wavelengths` of the info, else TOLIMAN_E_ARGUMENT. The weights of a star that is not there are 0. Any array may be
 * NULL. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_spectrum(const toliman_sim *sim, size_t count,
                                                                       double *wavelength_m, double *weight_a,
                                                                       double *weight_b) TOLIMAN_NOEXCEPT;

/* Relative error of the plate scale at each wavelength of the spectrum: by how much the padded FFT makes its image too
 * large, p D N_out / (lambda N_E) - 1; 0 for the matrix DFT. count as above. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_plate_scale(const toliman_sim *sim, size_t count,
                                                                          double *relative_error) TOLIMAN_NOEXCEPT;

/* Positions of the stars without displacement, from the frame's centre; NaN for a star that is not there. Since 0.2. */
typedef struct toliman_sim_offsets {
    uint32_t struct_size; /* in: sizeof(toliman_sim_offsets) */
    uint32_t reserved;    /* 0 */
    double a_x_px, a_y_px;
    double b_x_px, b_y_px;
} toliman_sim_offsets;
#define TOLIMAN_SIM_OFFSETS_INIT TOLIMAN_INIT(toliman_sim_offsets)

/* Fills *out; out->struct_size must be set. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_offsets(const toliman_sim *sim,
                                                                      toliman_sim_offsets *out) TOLIMAN_NOEXCEPT;

/* Expected image with the moving star displaced by displacement_px, each wavelength propagated anew (no series):
 * slow, exact, for tests and large displacements. In the frame's unit, without systematics but jitter.
 * |displacement_px| <= 100, else TOLIMAN_E_RANGE. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_propagate(const toliman_sim *sim, double displacement_px,
                                                                    double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Expected image by the series in the displacement, as frames without systematics use it; no light below 0. Its order
 * is that of the plan, chosen for the scene's own signal, at least 2. In the frame's unit. |displacement_px| <= 0.1,
 * else TOLIMAN_E_RANGE. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_expect(const toliman_sim *sim, double displacement_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Frame k >= 0 with the given displacement (as toliman_sim_expect; up to 100 px where the plan says exact_frames) and
 * seed: disturbed by the systematics of (seed, k), then through the detector's stages with noise of (seed, k). A frame
 * depends on (scene, displacement, seed, k) alone: the same on any thread and in any order, and on any machine given
 * the same image bytes (across CPU types the images agree to 1e-14 of peak, so that rare counts may differ).
 * TOLIMAN_E_RANGE also where a pixel would expect more than 1e12 electrons (photons, without qe). Calls from several
 * threads run side by side; with anchors (toliman_sim_plan_info) all wait while one of them makes the next. Since 0.1.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame(const toliman_sim *sim, double displacement_px,
                                                                uint64_t seed, int64_t k, double *image,
                                                                size_t stride) TOLIMAN_NOEXCEPT;

/* Frames first ... first + count - 1 into images[count][rows][cols], computed on `threads` workers (0 = one a
 * processor). With displacements NULL they are frames of the cadence with the scene's own signal, TOLIMAN_E_RANGE
 * outside it; with displacements[count] they may have any numbers from 0. Errors as toliman_sim_frame; after one, or
 * without memory, images may hold some of them. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame_many(const toliman_sim *sim,
                                                                     const double *displacements_px, uint64_t seed,
                                                                     int64_t first, size_t count, uint32_t threads,
                                                                     double *images) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
