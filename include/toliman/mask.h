/* libtoliman, mask: designs a phase mask with a smaller Cramer-Rao bound of the separation.
 *
 * Data flow (toliman_mask_...)
 *
 *   toliman_sim -> create, destroy -> toliman_mask
 *   scores of the designed mask and of the scene's own   get_info, get_place
 *   the mask, for a scene file -> sim.h                  get_cells, get_json
 *   the bound in each iteration                          get_descent
 *
 * A mask is better if, at every place of the stars, its bound is smaller and its peak-to-mean ratio
 * (toliman_sim_bounds) within the limit. */
#ifndef TOLIMAN_MASK_H
#define TOLIMAN_MASK_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Designed mask with its scores. */
typedef struct toliman_mask toliman_mask;

/* Symmetry of a mask under a rotation of the pupil by 180 degrees. */
#define TOLIMAN_MASK_SYMMETRY_NONE 841
#define TOLIMAN_MASK_SYMMETRY_EVEN 842 /* unchanged */
#define TOLIMAN_MASK_SYMMETRY_ODD 843  /* becomes its complement, as spirals of odd m */

/* Options of a design. */
typedef struct toliman_mask_options {
    uint32_t struct_size;
    uint32_t threads;
    uint64_t seed;    /* of the random spirals at the start */
    const char *free; /* list of the parameters fitted with the separation, from flux_a, flux_b, shift_x, shift_y,
                         roll, scale, focus and background; "" = none; NULL = all of the scene */
    /* Places of the stars: at most one of the two lists; neither: that of the scene. */
    const double *dates;               /* [date_count] Julian years, with binary.orbit */
    size_t date_count;                 /* in [0, 64] */
    const double *position_angles_deg; /* [position_angle_count], with binary.position_angle_deg */
    size_t position_angle_count;       /* in [0, 64] */
    double peak_to_mean;               /* limit of the ratio at each place, in (1, inf); 0 = that of the scene's mask
                                          there */
    double light_in_frame;             /* least fraction, in (0, 1); 0 = 0.875 (no limit in a scene that gives
                                          peak_photons) */
    uint32_t feature_cells;            /* smallest feature in cells, in [1, 16]; 0 = 2 */
    int32_t symmetry;                  /* TOLIMAN_MASK_SYMMETRY_..., 0 = NONE */
    uint32_t iterations;               /* of the first descent, about half of all, in [1, 100000]; 0 = 250 */
    uint32_t reserved;
    toliman_progress_fn progress; /* stages such as "polish: bound 1.8e-06 px" */
    void *progress_data;
} toliman_mask_options;
#define TOLIMAN_MASK_OPTIONS_INIT TOLIMAN_INIT(toliman_mask_options)

/* Designs a mask. Its cells have the step of the scene's mask or, if the scene has none, an OPD of half the middle
 * wavelength. Takes minutes. A mask depends on the scene and options only (promise: masks-ignore-threads). If it is not
 * better, try another seed.
 * Errors: TOLIMAN_E_SCENE if the separation has no bound, and for places that the scene cannot have;
 * TOLIMAN_E_UNSUPPORTED with PADDED_FFT; those of toliman_sim_create_file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_create(const toliman_sim *sim,
                                                                  const toliman_mask_options *options,
                                                                  toliman_mask **out) TOLIMAN_NOEXCEPT;

/* Destroys a mask. */
TOLIMAN_API void toliman_mask_destroy(toliman_mask *mask) TOLIMAN_NOEXCEPT;

/* Scores at one place of the stars, of the designed mask and (_before) the scene's own. Bounds may be infinite. */
typedef struct toliman_mask_info {
    uint32_t struct_size;
    int32_t improved; /* 1: the mask is better */
    int32_t stopped;  /* 1: the progress callback ended the design */
    uint32_t reserved;
    uint64_t iterations;
    double crb_before_px; /* with `free` of the options free */
    double crb_px;
    double peak_to_mean_before;
    double peak_to_mean;
    double light_in_frame_before; /* fraction of the stars' photons */
    double light_in_frame;
    double gradient_energy_before; /* as in toliman_sim_bounds, px^-2 */
    double gradient_energy;
    double crb_alone_before_px; /* all else known */
    double crb_alone_px;
    double crb_flux_shift_before_px; /* fluxes and common shift free */
    double crb_flux_shift_px;
    double radius_50_before_px; /* about the barycentre of the frame, with half of its light */
    double radius_50_px;
    double radius_80_before_px; /* with 80 % */
    double radius_80_px;
    double quantum_px;            /* quantum bound: smallest crb_alone_px of this pupil with any phase mask and
                                     photon noise only */
    double quantum_flux_shift_px; /* likewise; infinite for a single star */
    double small_features;        /* fraction of the open cells below feature_cells */
} toliman_mask_info;
#define TOLIMAN_MASK_INFO_INIT TOLIMAN_INIT(toliman_mask_info)

/* Gets the scores at the first place, or at place number `place`; improved, stopped, iterations and small_features are
 * those of all places. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_info(const toliman_mask *mask,
                                                                    toliman_mask_info *out) TOLIMAN_NOEXCEPT;
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_place(const toliman_mask *mask, int64_t place,
                                                                     toliman_mask_info *out) TOLIMAN_NOEXCEPT;

/* Writes the cells to cells[side][side], side = telescope.pupil_samples: 1 where the mask steps, else 0, also in cells
 * that the aperture blocks. As .npy of uint8, they are the file of a scene's mask. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_cells(const toliman_mask *mask, size_t side,
                                                                     double *cells) TOLIMAN_NOEXCEPT;

/* Writes the bound in each iteration, with coarse images, px, to bounds_px[count]; count is
 * toliman_mask_info.iterations. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_descent(const toliman_mask *mask, size_t count,
                                                                       double *bounds_px) TOLIMAN_NOEXCEPT;

/* Returns telescope.mask of a scene as JSON on one line: {"kind": "file", "file": "mask.npy", "quantity": "binary",
 * "opd_nm": ...}; the caller writes the file. "" for NULL and after an error, which sets toliman_last_error(). Valid
 * until the mask is destroyed. */
TOLIMAN_API const char *toliman_mask_get_json(const toliman_mask *mask) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
