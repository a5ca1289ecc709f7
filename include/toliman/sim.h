/* libtoliman, simulator: from a scene file to expected images, noisy frames and what they can tell at best.
 *
 * Conventions
 *   Arrays      C order, [row][column] = [y][x]; row 0 and column 0 are the most negative coordinates.
 *   Pupil       sample i stands at x_i = (i - (N-1)/2) D/N, the cell's centre; D the aperture, N the pupil samples.
 *   Detector    pixel j stands at u_j = (j - (n-1)/2) p, p the pixel scale; for even n the axis is the corner of the
 *               four middle pixels. Offsets are given in pixels from there, x to higher columns, y to higher rows.
 *   Pupil       A = open fraction of the cell times the amplitude t of the scene's file (1 without one), in 0..1. OPD =
 *               mask + Zernike polynomials (Noll's order, rms over the full aperture; where A > 0) + OPD file.
 *   Signs       E = A exp(+2 pi i OPD/lambda), F(u,v) = sum E exp(-2 pi i (x u + y v)/lambda). A star at offset
 *               (+ox, +oy) px has OPD +(x ox + y oy) p and its image stands at higher column and row.
 *   Angle       position angle of B seen from A, from +y towards -x (north up, east left).
 *   Separation  positive displacement lengthens it: star A moves away from B, or B from A. A star alone moves towards
 *               higher columns.
 *   Intensity   fraction of the light through the pupil that falls in a pixel, |F|^2 (D/N p/lambda)^2 / sum(A t): sums
 *               to 1 over an infinite image. What an amplitude file absorbs is not counted: t = 1/2 everywhere changes
 *               nothing, and photons_per_s of a scene are at the detector. Light outside the frame is lost.
 *   Time        0 at frame 0; with an orbit the stars stand where they are at binary.date, which is time 0, throughout.
 *   Planet      moves its star by a m/(M + m) r/a sin(true anomaly + argument) along the axis, as if the orbit's plane
 *               held it: argument 0 is a sine of phase_rad, the mean anomaly at time 0. On an eccentric orbit the mean
 *               over a period is not 0 but -3/2 e sin(argument) amplitudes.
 *   Spectrum    uniform steps, both ends at half weight (trapezium); one wavelength or lines as they are.
 *   Detector    its rotation is the position angle of the rows' +y axis: a star at that angle stands at +y.
 *   Pixel       point sampling at the pixel's centre.
 */
#ifndef TOLIMAN_SIM_H
#define TOLIMAN_SIM_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* A scene made ready: PSFs and derivative images computed once, then frames by random access. Const calls may run on
 * one simulator from several threads. Since 0.1. */
typedef struct toliman_sim toliman_sim;

typedef struct toliman_sim_options {
    uint32_t struct_size;
    uint32_t threads;             /* own workers; 0 = one a processor. Never changes a bit of any result */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
    toliman_log_fn log; /* may be NULL */
    void *log_data;
} toliman_sim_options;

/* Fills *options with the defaults. Since 0.1. */
TOLIMAN_API void toliman_sim_options_init(toliman_sim_options *options) TOLIMAN_NOEXCEPT;

/* Simulator of the scene file at path (schema toliman-scene/1); relative file names inside it start at its folder.
 * options may be NULL. The caller destroys *out. TOLIMAN_E_NOT_FOUND or _FORMAT for this or a named file, _SCENE for
 * impossible content, _UNSUPPORTED, _CANCELLED, _MEMORY. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create(const char *path, const toliman_sim_options *options,
                                                                 toliman_sim **out) TOLIMAN_NOEXCEPT;

/* The same from JSON text of `size` bytes in memory; folder is where relative file names start (NULL = the current
 * one). Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_create_json(const char *json, size_t size, const char *folder,
                                                                      const toliman_sim_options *options,
                                                                      toliman_sim **out) TOLIMAN_NOEXCEPT;

/* Ends a simulator; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_sim_destroy(toliman_sim *sim) TOLIMAN_NOEXCEPT;

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
    double peak_photons;   /* brightest pixel of the mean frame */
    double total_photons;  /* in the frame */
    /* Cramer-Rao bounds of the separation a frame; infinite where the frame tells nothing of it */
    double crb_px;            /* all else known; finite where the scene has a signal */
    double crb_flux_shift_px; /* the same with both fluxes and the common shift unknown */
    double crb_projected_px;  /* the same with exactly preprocess.project unknown; the yardstick of efficiency */
    double truncation;        /* predicted error of the order-2 series, largest pixel over that of the signal, at the
                                 signal's largest displacement; above the scene's accuracy it is logged as a warning */
    double min_displacement_px, max_displacement_px; /* of the signal over the cadence */
    double amplitude_uas;                            /* amplitude_px on the sky, microarcsec */
    double aperture_m;                               /* diameter */
    double pixel_scale_arcsec;                       /* of a detector pixel */
    uint64_t scene_digest;                           /* FNV-1a of the scene's text, as in the weights trained for it */
    int64_t whole_counts; /* 1 if frames hold whole numbers (photon noise alone, or a bit depth), else 0 */
    double peak_counts;   /* brightest pixel of the mean frame, in the frame's own unit */
} toliman_sim_info;

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_info(const toliman_sim *sim,
                                                                   toliman_sim_info *out) TOLIMAN_NOEXCEPT;

/* Name of the scene; lives as long as sim. "" for NULL. Since 0.1. */
TOLIMAN_API const char *toliman_sim_get_name(const toliman_sim *sim) TOLIMAN_NOEXCEPT;

/* Times (days) and true displacements (px) of frames first ... first + count - 1; either array may be NULL.
 * TOLIMAN_E_RANGE outside the cadence. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_series(const toliman_sim *sim, int64_t first,
                                                                     size_t count, double *times_days,
                                                                     double *displacements_px) TOLIMAN_NOEXCEPT;

/* Noise-free images, in expected photons of a frame (derivatives: per unit of the quantity). */
#define TOLIMAN_IMAGE_BOTH 0       /* the whole frame without displacement */
#define TOLIMAN_IMAGE_STAR_A 1     /* also the derivative with respect to the relative flux of A */
#define TOLIMAN_IMAGE_STAR_B 2     /* E_ARGUMENT for a single star */
#define TOLIMAN_IMAGE_SEPARATION 3 /* d/d separation, per px */
#define TOLIMAN_IMAGE_CURVATURE 4  /* second derivative, per px^2 */
#define TOLIMAN_IMAGE_SHIFT_X 5    /* d/d common shift towards higher columns, per px */
#define TOLIMAN_IMAGE_SHIFT_Y 6    /* d/d common shift towards higher rows, per px */
/* Variance of the counts, photons^2: expected photons + read_e^2, even where the scene draws no photon noise; at least
 * 1e-12 of the brightest pixel. */
#define TOLIMAN_IMAGE_VARIANCE 7
/* Copies one of them into image[rows][stride], stride >= cols in elements. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_image(const toliman_sim *sim, int32_t kind, double *image,
                                                                    size_t stride) TOLIMAN_NOEXCEPT;

/* Pupil of the scene, each [N][N]: amplitude A in 0..1 (grey edges) and OPD in m, of mask and aberrations. Either may
 * be NULL. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_pupil(const toliman_sim *sim, double *amplitude,
                                                                    double *opd_m) TOLIMAN_NOEXCEPT;

/* Spectrum as used: wavelengths (m) and photon weights of A and B a frame (whole star, before cropping); count must be
 * `wavelengths` of the info. The weights of a star that is not there are 0. Any array may be NULL. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_spectrum(const toliman_sim *sim, size_t count,
                                                                       double *wavelength_m, double *weight_a,
                                                                       double *weight_b) TOLIMAN_NOEXCEPT;

/* Positions of the stars without displacement: offsets_px = {Ax, Ay, Bx, By}; NaN for a star that is not there.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_offsets(const toliman_sim *sim,
                                                                      double offsets_px[4]) TOLIMAN_NOEXCEPT;

/* Expected image with the moving star displaced by displacement_px, each wavelength propagated anew (no series):
 * slow, exact, for tests and large displacements. |displacement_px| <= 100, else TOLIMAN_E_RANGE. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_propagate(const toliman_sim *sim, double displacement_px,
                                                                    double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Expected image by the order-2 series, as frames use it; not below 0. |displacement_px| <= 0.1, else TOLIMAN_E_RANGE.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_expect(const toliman_sim *sim, double displacement_px,
                                                                 double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Noisy counts of frame k >= 0 with the given displacement and noise seed: Poisson photons, then read noise where the
 * scene has it. A frame depends on (scene, displacement, seed, k) alone: the same on any thread and in any order, and
 * on any machine given the same image bytes (across CPU types the images agree to 1e-14 of peak, so that rare counts
 * may differ). Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame(const toliman_sim *sim, double displacement_px,
                                                                uint64_t seed, int64_t k, double *image,
                                                                size_t stride) TOLIMAN_NOEXCEPT;

/* Frames first ... first + count - 1 into images[count][rows][cols], computed on `threads` workers (0 = one a
 * processor). With displacements NULL they are frames of the cadence with the scene's own signal, TOLIMAN_E_RANGE
 * outside it; with displacements[count] they may have any numbers from 0. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_frame_many(const toliman_sim *sim, uint64_t seed,
                                                                     int64_t first, size_t count,
                                                                     const double *displacements_px, uint32_t threads,
                                                                     double *images) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
