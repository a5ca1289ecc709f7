/* libtoliman, mask: searches for a phase mask with a smaller Cramer-Rao bound of the separation.
 *
 * Data flow (functions toliman_mask_...)
 *
 *   toliman_sim -> search -> toliman_mask -> get_info   scores of the scene's own mask and of the best one
 *    (options_init)               |       -> get_json   the mask, for a scene file -> sim.h
 *                              destroy
 *
 * Scores
 *
 *   A mask is scored by the expected frame of its scene: the Cramer-Rao bound of the separation with all else known,
 *   the peak-to-mean ratio (brightest pixel over mean pixel, before the detector), and the fraction of the light of
 *   the stars that falls in the frame. A better mask has a smaller bound, and a peak-to-mean ratio not above that of
 *   the mask of the scene, so that it needs no more dynamic range of the detector. In a scene that gives peak_photons,
 *   light outside the frame does not count as a loss.
 */
#ifndef TOLIMAN_MASK_H
#define TOLIMAN_MASK_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Best mask that was found for a scene, with its scores. Immutable: any number of threads may use one object. Since
 * 0.2. */
typedef struct toliman_mask toliman_mask;

/* Options of a search. Since 0.2. */
typedef struct toliman_mask_options {
    uint32_t struct_size;
    uint32_t threads;             /* worker threads, 0 = one per processor */
    uint64_t seed;                /* seed of the random masks */
    uint64_t count;               /* largest number of masks to draw and vary; 0 = 4000, or no limit with minutes */
    double minutes;               /* time limit, 0 ... 100000; 0 = none */
    toliman_progress_fn progress; /* stages "draw", "refine", "polish", each with the best bound so far ("draw: best
                                     1.2e-06 px"). A nonzero value ends the search: its result is the best mask so
                                     far, not TOLIMAN_E_CANCELLED. May be NULL */
    void *progress_data;
} toliman_mask_options;
#define TOLIMAN_MASK_OPTIONS_INIT TOLIMAN_INIT(toliman_mask_options)

/* Sets *options, a struct of `size` bytes, to the defaults. Since 0.2. */
TOLIMAN_API void toliman_mask_options_init(toliman_mask_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Searches for a spiral mask that is better than the mask of the scene (see Scores above): masks are drawn at random,
 * then the best of them and the scene's own spiral are varied, both with fewer wavelengths and, where possible, half
 * the pupil samples; finally the best masks are evaluated and improved with the full scene. The step of every mask is
 * opd_nm or height_nm of the scene's mask; without one, an OPD of half the middle wavelength. options may be NULL. The
 * simulator is not needed afterwards, but the files that its scene names are read again. The caller destroys *out.
 * Without a time limit the result depends only on the scene, seed and count, not on threads.
 * If no mask is better, the call succeeds and toliman_mask_info.improved is 0.
 * Errors: TOLIMAN_E_SCENE if the scene's own bound is infinite, TOLIMAN_E_UNSUPPORTED for the engine PADDED_FFT, and
 * those of toliman_sim_create_file for the files of the scene. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_search(const toliman_sim *sim,
                                                                  const toliman_mask_options *options,
                                                                  toliman_mask **out) TOLIMAN_NOEXCEPT;

/* Destroys a mask. NULL is allowed. Since 0.2. */
TOLIMAN_API void toliman_mask_destroy(toliman_mask *mask) TOLIMAN_NOEXCEPT;

/* Scores of a mask and of the mask of the scene it was found for ("before"). Equal unless improved. Since 0.2. */
typedef struct toliman_mask_info {
    uint32_t struct_size;         /* in: sizeof(toliman_mask_info) */
    int32_t improved;             /* 1 if the mask is better than that of the scene, else 0 */
    int32_t stopped;              /* 1 if the progress callback ended the search, else 0 */
    uint32_t reserved;            /* 0 */
    uint64_t tried;               /* number of masks drawn and varied */
    double crb_before_px;         /* Cramer-Rao bound of one frame with all else known: mask of the scene, */
    double crb_px;                /* this mask */
    double peak_to_mean_before;   /* brightest pixel over mean pixel of the noise-free frame: mask of the scene, */
    double peak_to_mean;          /* this mask */
    double light_in_frame_before; /* fraction of the photons of the stars that falls in the frame: mask of the scene, */
    double light_in_frame;        /* this mask */
    double gradient_energy_before; /* toliman_sim_bounds.gradient_energy, px^-2: mask of the scene, */
    double gradient_energy;        /* this mask */
} toliman_mask_info;
#define TOLIMAN_MASK_INFO_INIT TOLIMAN_INIT(toliman_mask_info)

/* Writes the scores of a mask to *out, whose struct_size must be set. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_mask_get_info(const toliman_mask *mask,
                                                                    toliman_mask_info *out) TOLIMAN_NOEXCEPT;

/* Returns the mask as JSON on one line, the value of telescope.mask of a scene: {"kind": "spiral", ...}. Every number
 * is read again as the same double. "" if no mask was better, and for NULL. Valid until the mask is destroyed. Since
 * 0.2. */
TOLIMAN_API const char *toliman_mask_get_json(const toliman_mask *mask) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
