/* libtoliman, components: principal components and sparse dictionaries of frames, baselines without knowledge of the
 * signal.
 *
 * Data flow (toliman_components_...)
 *
 *   toliman_sim -> create -> toliman_components <- push <- frames
 *                  train -> get_series -> one value per frame -> period.h
 *                  get_info, destroy */
#ifndef TOLIMAN_COMPONENTS_H
#define TOLIMAN_COMPONENTS_H

#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Frames of a scene and their components, in the order of the pushes. */
typedef struct toliman_components toliman_components;

/* Options of a collection. */
typedef struct toliman_components_options {
    uint32_t struct_size;
    int32_t raw;       /* 0 or 1; 0: residuals (counts - reference)/sigma with preprocess.project projected out; 1:
                          counts */
    uint32_t bin;      /* side of blocks of pixels that are summed; divides rows and cols; 0 = 1 */
    uint32_t capacity; /* in [2, 16384]; 0 = number of frames of the scene's cadence */
    const toliman_allocator *allocator;
    toliman_log_fn log; /* receives warnings about preprocess.project */
    void *log_data;
} toliman_components_options;
#define TOLIMAN_COMPONENTS_OPTIONS_INIT TOLIMAN_INIT(toliman_components_options)

/* Creates an empty collection with the memory of all frames, 4 bytes per binned pixel. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_create(const toliman_sim *sim,
                                                                        const toliman_components_options *options,
                                                                        toliman_components **out) TOLIMAN_NOEXCEPT;

/* Destroys a collection. */
TOLIMAN_API void toliman_components_destroy(toliman_components *components) TOLIMAN_NOEXCEPT;

/* Adds `count` frames of image, or, after an error, none (promise: components-take-all-or-none). Discards trained
 * components. Errors: image.h; TOLIMAN_E_RANGE for a count beyond float32; TOLIMAN_E_CAPACITY if the collection becomes
 * full. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_push(toliman_components *components,
                                                                      const toliman_image *image,
                                                                      size_t count) TOLIMAN_NOEXCEPT;

/* Methods of toliman_components_train. */
#define TOLIMAN_COMPONENTS_PCA 401
#define TOLIMAN_COMPONENTS_DICTIONARY 402

/* Training options. */
typedef struct toliman_components_train_options {
    uint32_t struct_size;
    int32_t method;      /* TOLIMAN_COMPONENTS_..., 0 = PCA */
    uint32_t components; /* in [1, 64] and fewer than frames; 0 = 1 */
    uint32_t threads;
    uint32_t iterations; /* dictionary: largest number; 0 = 200 */
    uint32_t reserved;
    double lambda; /* dictionary: in (0, 1e6]; 0 = 1 */
    uint64_t seed; /* likewise, of the initial atoms */
    toliman_progress_fn progress;
    void *progress_data;
} toliman_components_train_options;
#define TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_components_train_options)

/* Training result. */
typedef struct toliman_components_training {
    uint32_t struct_size;
    uint32_t iterations;
    int32_t converged; /* 1: the last iteration improved the objective by less than 1e-5 of the total */
    uint32_t reserved;
    double objective; /* dictionary: over that without atoms, 0 to 1 */
} toliman_components_training;
#define TOLIMAN_COMPONENTS_TRAINING_INIT TOLIMAN_INIT(toliman_components_training)

/* Finds components of the pushed frames minus their mean. report may be NULL.
 *   PCA         leading eigenvectors: series are projections on principal images
 *   DICTIONARY  a local minimum of the sum of |x - D a|^2/2 + lambda s |a|_1 over codes a and atoms |D_j| <= 1, s: rms
 *               of all pixels; sorted by energy (Mairal et al. 2009)
 * The largest element of a series is positive. The same frames, options and seed give the same bits
 * (promise: components-repeat-their-bits); the last bits of PCA depend on the threads of OpenBLAS.
 * Errors: TOLIMAN_E_STATE for fewer than components + 1 frames. After a cancelled call, components of an earlier
 * training remain (promise: cancelled-components-remain). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_train(toliman_components *components, const toliman_components_train_options *options,
                         toliman_components_training *report) TOLIMAN_NOEXCEPT;

/* Writes the series of a component. Errors: TOLIMAN_E_STATE before training.
 *   values  [frames] or NULL, in units of the (binned) residuals; for PCA the mean square is the eigenvalue
 *   share   or NULL: of the component in the sum of squares of the frames about their mean; those of a dictionary need
 *           not add up to 1 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_get_series(const toliman_components *components,
                                                                            int64_t component, double *values,
                                                                            double *share) TOLIMAN_NOEXCEPT;

/* Properties of a collection. */
typedef struct toliman_components_info {
    uint32_t struct_size;
    int32_t raw;
    uint32_t bin;
    uint32_t projected;
    int64_t capacity;
    int64_t frames;
    int64_t pixels;     /* after binning */
    int64_t components; /* 0 before training */
    double crb_px;      /* of a binned frame, projected nuisances unknown; NaN if raw */
    /* Smallest amplitude (px) of a sinusoidal separation to which the leading principal component responds: crb_px
     * sqrt(2 sqrt(p/N)) for N frames, p = pixels - projected (Baik, Ben Arous, Peche 2005). +infinity without frames,
     * NaN if raw. */
    double threshold_px;
} toliman_components_info;
#define TOLIMAN_COMPONENTS_INFO_INIT TOLIMAN_INIT(toliman_components_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_get_info(const toliman_components *components, toliman_components_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
