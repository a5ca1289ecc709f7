/* libtoliman, components: principal components and sparse dictionaries of frames, the classical baselines that know
 * nothing of the signal.
 *
 * Data flow (functions toliman_components_...)
 *
 *   toliman_sim -> create -> toliman_components <- push, push_many <- frames
 *     (options_init)               |
 *    train_options_init ->       train -> get_series -> one value a frame -> period.h
 *                                get_info
 *                                reset, destroy
 */
#ifndef TOLIMAN_COMPONENTS_H
#define TOLIMAN_COMPONENTS_H

#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Frames of a scene, collected to find their components. One series of numbers a component comes out, one number a
 * frame, in the order of the pushes. Const calls may run on one object from several threads. Since 0.1. */
typedef struct toliman_components toliman_components;

/* What a collection takes. Since 0.1. */
typedef struct toliman_components_options {
    uint32_t struct_size;
    uint32_t raw;      /* 0: residuals against the scene's reference over the scene's sigma, less the nuisances of
                          preprocess.project; 1: counts */
    uint32_t bin;      /* pixels a side that are summed first, whitened as one pixel; divides rows and columns; 0 = 1 */
    uint32_t capacity; /* frames, 2 ... 16384; 0 = those of the scene's cadence */
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
} toliman_components_options;
#define TOLIMAN_COMPONENTS_OPTIONS_INIT TOLIMAN_INIT(toliman_components_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_components_options_init(toliman_components_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Empty collection for frames of a scene; options may be NULL, sim is not kept. Takes all memory of the frames here, 4
 * bytes a (binned) pixel and frame: residuals are held as float32, wrong by 6e-8 of themselves at most. The caller
 * destroys *out. TOLIMAN_E_ARGUMENT for impossible options. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_create(const toliman_sim *sim,
                                                                        const toliman_components_options *options,
                                                                        toliman_components **out) TOLIMAN_NOEXCEPT;

/* Ends a collection; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_components_destroy(toliman_components *components) TOLIMAN_NOEXCEPT;

/* Adds a frame of counts[rows][stride] (shape of the scene) and forgets what was trained. TOLIMAN_E_ARGUMENT for a
 * non-finite count, with its row and column; TOLIMAN_E_RANGE for one beyond float32; TOLIMAN_E_CAPACITY when full.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_push(toliman_components *components,
                                                                      const double *counts,
                                                                      size_t stride) TOLIMAN_NOEXCEPT;

/* Adds `count` frames of image, of any kind of pixels, in their order. Errors as of toliman_components_push, with the
 * number of the frame, of which no frame is then added; TOLIMAN_E_ARGUMENT for another shape, TOLIMAN_E_RANGE for
 * frames that do not fit in memory. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_push_many(toliman_components *components,
                                                                           const toliman_image *image,
                                                                           size_t count) TOLIMAN_NOEXCEPT;

/* Forgets every frame; options and memory stay. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_reset(toliman_components *components) TOLIMAN_NOEXCEPT;

/* Ways to find components, see toliman_components_train. */
#define TOLIMAN_COMPONENTS_PCA 401
#define TOLIMAN_COMPONENTS_DICTIONARY 402

/* How to train. Since 0.1. */
typedef struct toliman_components_train_options {
    uint32_t struct_size;
    int32_t method;      /* 0 = TOLIMAN_COMPONENTS_PCA, or TOLIMAN_COMPONENTS_DICTIONARY */
    uint32_t components; /* 1 ... 64, less than frames; 0 = 1 */
    uint32_t threads;    /* own workers; 0 = one a processor. Never changes a bit of any result */
    uint32_t iterations; /* of the dictionary, at most; 0 = 200 */
    uint32_t reserved;   /* 0 */
    double lambda;       /* of the dictionary: weight of the codes' L1 norm, in rms pixels; in [0, 1e6], 0 = 1 */
    uint64_t seed;       /* of the random atoms that the dictionary starts with */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_components_train_options;
#define TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_components_train_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_components_train_options_init(toliman_components_train_options *options,
                                                       size_t size) TOLIMAN_NOEXCEPT;

/* What a training came to. Since 0.1. */
typedef struct toliman_components_training {
    uint32_t struct_size; /* in: sizeof(toliman_components_training) */
    uint32_t iterations;  /* done; 0 for PCA */
    uint32_t converged;   /* 1: the last iteration added less than 1e-5 of the gain; 0: their number ended it */
    uint32_t reserved;
    double objective; /* of the dictionary over that of no atoms, 0 ... 1; 0 for PCA and for frames that are equal */
} toliman_components_training;
#define TOLIMAN_COMPONENTS_TRAINING_INIT TOLIMAN_INIT(toliman_components_training)

/* Finds components of the frames pushed, whose mean is subtracted first. The products of all frames with all, which
 * take the time, are kept, 8 bytes each, for further trainings until the next push. options and report may be NULL.
 *   PCA         leading eigenvectors; series j is that of the frames' components along the j-th principal image.
 *   dictionary  codes a and atoms D, |D_j| <= 1, that make the sum of |x - D a|^2/2 + lambda rms |a|_1 small, from
 *               random atoms in the frames' span: a local minimum. Sorted by energy.
 * The element of a series with the largest magnitude is positive. Equal frames have series of zeros; where eigenvalues
 * are equal, any basis of their space may come. Same frames, options and seed, same bits, as long as OpenBLAS runs as
 * many threads (PCA's last bits depend on it). TOLIMAN_E_STATE for fewer than components + 1 frames,
 * TOLIMAN_E_ARGUMENT, TOLIMAN_E_CANCELLED; what was trained before then stays. Source: Jolliffe (2002); Mairal, Bach,
 * Ponce, Sapiro (2009), with all frames at once. Since 0.1.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_train(toliman_components *components, const toliman_components_train_options *options,
                         toliman_components_training *report) TOLIMAN_NOEXCEPT;

/* Series of component 0, 1, ... into values[frames], and its share of the frames' sum of squares about their mean
 * (atoms are not orthogonal: their shares need not add up); either may be NULL. In the units of the (binned) residuals:
 * of PCA the mean square is the eigenvalue of the covariance matrix sum x x^T/frames. TOLIMAN_E_STATE before training,
 * TOLIMAN_E_RANGE for a component beyond those trained. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_get_series(const toliman_components *components,
                                                                            uint32_t component, double *values,
                                                                            double *share) TOLIMAN_NOEXCEPT;

/* Facts of a collection. Since 0.1. */
typedef struct toliman_components_info {
    uint32_t struct_size; /* in: sizeof(toliman_components_info) */
    uint32_t raw, bin;
    uint32_t projected; /* nuisance images projected out; 0 if raw */
    int64_t capacity, frames;
    int64_t pixels;     /* of a frame, after binning */
    int64_t components; /* trained; 0 before */
    double crb_px;      /* Cramer-Rao bound of a frame's binned pixels with the projected images free; NaN if raw */
    /* Amplitude of a sinusoid of the separation below which the leading principal component knows nothing of it, when
     * frames and pixels are many: p = pixels - projected white ones and N frames have an eigenvalue A^2/(2 crb^2),
     * which must exceed sqrt(p/N), hence A = crb sqrt(2 sqrt(p/N)). +infinity without frames, NaN if raw. Source: Baik,
     * Ben Arous, Peche (2005); above it, with the eigenvalue l, the principal image's squared cosine with the signal's
     * is (1 - p/N/l^2)/(1 + p/N/l) (Paul 2007), the series' squared correlation (1 - p/N/l^2)/(1 + 1/l)
     * (Benaych-Georges and Nadakuditi 2012). */
    double threshold_px;
} toliman_components_info;
#define TOLIMAN_COMPONENTS_INFO_INIT TOLIMAN_INIT(toliman_components_info)

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_get_info(const toliman_components *components, toliman_components_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
