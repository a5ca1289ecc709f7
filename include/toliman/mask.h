/* libtoliman, mask: designs a phase mask with a smaller Cramer-Rao bound of the separation.
 *
 * Data flow (functions toliman_mask_...)
 *
 *   toliman_sim -> create -> toliman_mask -> get_info, get_place   scores of the designed mask and of the scene's own
 *                                 |       -> get_cells             the cells of the mask
 *                                 |       -> get_json              the mask, for a scene file -> sim.h
 *                              destroy    -> get_descent           the bound in each iteration
 *
 *   A design descends on the gradient of the bound, with nuisances free and for several places of the stars. On the
 *   scene mission.json with the eight nuisances free, a design has a bound of 1.8e-6 to 1.9e-6 px, the shipped spiral
 *   3.3e-6 px.
 *
 * Scores
 *
 *   A mask is scored by the expected frame of its scene: Cramer-Rao bounds of the separation, the peak-to-mean ratio
 *   (brightest pixel over mean pixel, before the detector), and the fraction of the light of the stars that falls in
 *   the frame. A mask is better if its bound is smaller at every place and its peak-to-mean ratio is nowhere above the
 *   limit, so that it needs no more dynamic range of the detector.
 */
#ifndef TOLIMAN_MASK_H
#define TOLIMAN_MASK_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* A designed mask with its scores. Immutable: any number of threads may use one object. */
typedef struct toliman_mask toliman_mask;

/* Symmetry of a designed mask under a rotation of the pupil by 180 degrees. */
#define TOLIMAN_MASK_SYMMETRY_NONE 841
#define TOLIMAN_MASK_SYMMETRY_EVEN 842 /* the mask is itself */
#define TOLIMAN_MASK_SYMMETRY_ODD 843  /* the mask is its complement, as spirals of odd m are */

/* Options of a design. */
typedef struct toliman_mask_options {
    uint32_t struct_size;
    uint32_t threads; /* worker threads, 0 = one per processor */
    uint64_t seed;    /* seed of the random spirals that it starts from */
    const char *free; /* list of the parameters that are fitted together with the separation, of flux_a, flux_b,
                         shift_x, shift_y, roll, scale, focus and background; "" = none; NULL = all of the scene */
    /* Places of the stars for which the mask is designed, at most one of the two lists; without, that of the scene. */
    const double *dates;               /* [date_count] Julian years; the scene must give the places by binary.orbit */
    size_t date_count;                 /* in [0, 64] */
    const double *position_angles_deg; /* [position_angle_count] of B from A; the scene must have
                                          binary.position_angle_deg */
    size_t position_angle_count;       /* in [0, 64] */
    double
        peak_to_mean; /* largest peak-to-mean ratio at every place, in (1, inf); 0 = that of the scene's mask there */
    double
        light_in_frame; /* smallest fraction of the light, in (0, 1); 0 = 0.875 (no limit in a scene that gives peak_photons). Most designs meet it to 1 % */
    uint32_t feature_cells; /* side of the smallest feature in cells of the pupil, in [1, 16]; 0 = 2 */
    int32_t symmetry;       /* TOLIMAN_MASK_SYMMETRY_..., 0 = NONE */
    uint32_t iterations; /* of the first descent, in [1, 100000]; 0 = 250. The whole takes 1.8 to 2.6 times as many */
    uint32_t reserved;   /* 0 */
    toliman_progress_fn progress; /* stages "draw", "descend", "polish", "correct", with the bound of the sketch
                                     ("polish: bound 1.8e-06 px"). A nonzero value ends the design: its result is the
                                     mask so far, not TOLIMAN_E_CANCELLED. May be NULL */
    void *progress_data;
} toliman_mask_options;
#define TOLIMAN_MASK_OPTIONS_INIT TOLIMAN_INIT(toliman_mask_options)

/* Creates a mask: designs steps on the cells of the pupil (see Data flow above): from the best of iterations/2 random
 * spirals, at most 125, Adam descends on the logarithm of the bound and penalties for pixels above the peak and for
 * light lost. The descent uses sketches: at most 128 cells per axis, the middle of the frame, and the wavelengths that
 * an accuracy of 1e-6 needs. Small features are then removed, and the scenes of all places judge the mask. The step is
 * opd_nm or height_nm of the scene's mask; without one, an OPD of half the middle wavelength. options may be NULL. The
 * simulator is not needed afterwards, but the files that its scene names are read again. The caller destroys *out. A
 * mask depends on the scene and options only (promise: masks-ignore-threads). mission.json takes one core 1 to 2
 * minutes.
 * If the mask is not better at all places, or exceeds the peak at one, the call succeeds and toliman_mask_info.improved
 * is 0: try another seed.
 * Errors: TOLIMAN_E_ARGUMENT for another name in `free`, or one that is named twice; TOLIMAN_E_SCENE if the separation
 * has no bound with these parameters free, and for places that the scene cannot have; TOLIMAN_E_UNSUPPORTED for the
 * engine PADDED_FFT; those of toliman_sim_create_file for the files of the scene. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_create(const toliman_sim *sim,
                                                                  const toliman_mask_options *options,
                                                                  toliman_mask **out) TOLIMAN_NOEXCEPT;

/* Destroys a mask. NULL is allowed. */
TOLIMAN_API void toliman_mask_destroy(toliman_mask *mask) TOLIMAN_NOEXCEPT;

/* Scores of a designed mask and of the mask of the scene ("before") at one place of the stars. Bounds are those of one
 * frame, infinite where the frame does not constrain the separation. */
typedef struct toliman_mask_info {
    uint32_t struct_size; /* in: sizeof(toliman_mask_info) */
    int32_t improved;     /* 1 if the mask is better than that of the scene, else 0 */
    int32_t stopped;      /* 1 if the progress callback ended the design, else 0 */
    uint32_t reserved;    /* 0 */
    uint64_t iterations;  /* of all descents */
    double crb_before_px; /* Cramer-Rao bound with the parameters `free` of the options free: mask of the scene, */
    double crb_px;        /* this mask */
    double peak_to_mean_before;   /* brightest pixel over mean pixel of the noise-free frame: mask of the scene, */
    double peak_to_mean;          /* this mask */
    double light_in_frame_before; /* fraction of the photons of the stars that falls in the frame: mask of the scene, */
    double light_in_frame;        /* this mask */
    double gradient_energy_before;   /* toliman_sim_bounds.gradient_energy, px^-2: mask of the scene, */
    double gradient_energy;          /* this mask */
    double crb_alone_before_px;      /* bound with all else known: mask of the scene, */
    double crb_alone_px;             /* this mask */
    double crb_flux_shift_before_px; /* bound with the fluxes and the common shift free: mask of the scene, */
    double crb_flux_shift_px;        /* this mask */
    double radius_50_before_px;      /* radius about the barycentre of the frame that has half of its light: mask of the
                                        scene, */
    double radius_50_px;             /* this mask */
    double radius_80_before_px;      /* the same for 80 % of the light */
    double radius_80_px;
    double quantum_px;            /* smallest crb_alone_px of this pupil with any mask that only delays, all light
                                     detected and no noise but that of photons (quantum Cramer-Rao bound) */
    double quantum_flux_shift_px; /* the same of crb_flux_shift_px; infinite for a single star */
    double small_features;        /* fraction of the open cells in features below feature_cells */
} toliman_mask_info;
#define TOLIMAN_MASK_INFO_INIT TOLIMAN_INIT(toliman_mask_info)

/* Writes the scores of a mask at its first place to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_info(const toliman_mask *mask,
                                                                    toliman_mask_info *out) TOLIMAN_NOEXCEPT;

/* Writes the scores at place number `place` to *out, whose struct_size must be set; improved, stopped, iterations and
 * small_features are those of the whole. TOLIMAN_E_RANGE for any other place. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_place(const toliman_mask *mask, int64_t place,
                                                                     toliman_mask_info *out) TOLIMAN_NOEXCEPT;

/* Writes the cells of the mask to cells[side][side], 1 where it steps and 0 elsewhere, also in cells without light;
 * side must be telescope.pupil_samples of the scene. As .npy of uint8, they are the file of a scene's mask.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_cells(const toliman_mask *mask, size_t side,
                                                                     double *cells) TOLIMAN_NOEXCEPT;

/* Writes the bound of the sketch with the free parameters in each iteration, px, to bounds_px[count]; count must be
 * toliman_mask_info.iterations. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_descent(const toliman_mask *mask, size_t count,
                                                                       double *bounds_px) TOLIMAN_NOEXCEPT;

/* Returns the mask as JSON on one line, the value of telescope.mask of a scene: {"kind": "file", "file": "mask.npy",
 * "quantity": "binary", "opd_nm": ...}, whose file the caller writes from the cells. Every number is read again as the
 * same double. "" for NULL and after an error. Valid until the mask is destroyed. */
TOLIMAN_API const char *toliman_mask_get_json(const toliman_mask *mask) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
