/* libtoliman, linear estimators: the template fit, which reaches the Cramer-Rao bound and is the reference for the CAE;
 * principal components and sparse dictionaries, the classical baselines that know nothing of the signal.
 *
 * Data flow (functions toliman_linear_...)
 *
 *   toliman_sim -> create -> toliman_linear -> encode -> value, px -> period.h
 *                                 |   get_sigma -> its standard deviation, px
 *                              destroy
 *
 *   toliman_sim -> create_components -> toliman_linear_components <- push_frame <- frames
 *    components_options_init                |
 *                  train_options_init    train_components -> get_series -> one value a frame -> period.h
 *                                        get_components_info
 *                                        reset_components, destroy_components
 */
#ifndef TOLIMAN_LINEAR_H
#define TOLIMAN_LINEAR_H

#include <toliman/base.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Weighted least-squares estimate of the separation of a frame: residual against the scene's reference image,
 * projected on the scene's separation derivative made orthogonal to preprocess.project. Const calls may run on one
 * object from several threads. Since 0.1. */
typedef struct toliman_linear toliman_linear;

/* Template estimator of a scene; sim is not kept, allocator may be NULL. TOLIMAN_E_SCENE when the nuisances of
 * preprocess.project leave nothing of the separation's derivative. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_create(const toliman_sim *sim,
                                                                    const toliman_allocator *allocator,
                                                                    toliman_linear **out) TOLIMAN_NOEXCEPT;

/* Ends an estimator; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_linear_destroy(toliman_linear *linear) TOLIMAN_NOEXCEPT;

/* Displacement (px) of one frame of counts[rows][stride] (shape of the scene). TOLIMAN_E_ARGUMENT for a non-finite
 * count, with its row and column. Source: Gauss-Markov; equals maximum likelihood to first order. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_encode(const toliman_linear *linear, const double *counts,
                                                                    size_t stride, double *value_px) TOLIMAN_NOEXCEPT;

/* Predicted standard deviation (px) of a value: the Cramer-Rao bound with preprocess.project free. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_sigma(const toliman_linear *linear,
                                                                       double *sigma_px) TOLIMAN_NOEXCEPT;

/* Frames of a scene, collected to find their components. One series of numbers a component comes out, one number a
 * frame, in the order of the pushes. Const calls may run on one object from several threads. Since 0.1. */
typedef struct toliman_linear_components toliman_linear_components;

/* What a collection takes. Since 0.1. */
typedef struct toliman_linear_components_options {
    uint32_t struct_size;
    uint32_t raw;      /* 0: residuals against the scene's reference over the scene's sigma, less the nuisances of
                          preprocess.project; 1: counts */
    uint32_t bin;      /* pixels a side that are summed first, whitened as one pixel; divides rows and columns; 0 = 1 */
    uint32_t capacity; /* frames, 2 ... 16384; 0 = those of the scene's cadence */
    const toliman_allocator *allocator; /* of the object's large arrays; NULL: the system's memory */
} toliman_linear_components_options;

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_linear_components_options_init(toliman_linear_components_options *options,
                                                        size_t size) TOLIMAN_NOEXCEPT;

/* Empty collection for frames of a scene; options may be NULL, sim is not kept. Takes all memory of the frames here, 4
 * bytes a (binned) pixel and frame: residuals are held as float32, wrong by 6e-8 of themselves at most. The caller
 * destroys *out. TOLIMAN_E_ARGUMENT for impossible options. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_linear_create_components(const toliman_sim *sim, const toliman_linear_components_options *options,
                                 toliman_linear_components **out) TOLIMAN_NOEXCEPT;

/* Ends a collection; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_linear_destroy_components(toliman_linear_components *components) TOLIMAN_NOEXCEPT;

/* Adds a frame of counts[rows][stride] (shape of the scene) and forgets what was trained. TOLIMAN_E_ARGUMENT for a
 * non-finite count, with its row and column; TOLIMAN_E_RANGE for one beyond float32; TOLIMAN_E_CAPACITY when full.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_push_frame(toliman_linear_components *components,
                                                                        const double *counts,
                                                                        size_t stride) TOLIMAN_NOEXCEPT;

/* Forgets every frame; options and memory stay. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_reset_components(toliman_linear_components *components)
    TOLIMAN_NOEXCEPT;

/* Ways to find components, see toliman_linear_train_components. */
#define TOLIMAN_LINEAR_PCA 0
#define TOLIMAN_LINEAR_DICTIONARY 1

/* How to train. Since 0.1. */
typedef struct toliman_linear_train_options {
    uint32_t struct_size;
    int32_t method;      /* TOLIMAN_LINEAR_PCA (default) or TOLIMAN_LINEAR_DICTIONARY */
    uint32_t components; /* 1 ... 64, less than frames; 0 = 1 */
    uint32_t threads;    /* own workers; 0 = one a processor. Never changes a bit of any result */
    uint32_t iterations; /* of the dictionary, at most; 0 = 200 */
    uint32_t reserved;   /* 0 */
    double lambda;       /* of the dictionary: weight of the codes' L1 norm, in rms pixels; in [0, 1e6], 0 = 1 */
    uint64_t seed;       /* of the random atoms that the dictionary starts with */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_linear_train_options;

/* Fills *options, which has `size` bytes, with the defaults. Since 0.1. */
TOLIMAN_API void toliman_linear_train_options_init(toliman_linear_train_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* What a training came to. Since 0.1. */
typedef struct toliman_linear_training {
    uint32_t struct_size; /* in: sizeof(toliman_linear_training) */
    uint32_t iterations;  /* done; 0 for PCA */
    uint32_t converged;   /* 1: the last iteration added less than 1e-5 of the gain; 0: their number ended it */
    uint32_t reserved;
    double objective; /* of the dictionary over that of no atoms, 0 ... 1; 0 for PCA and for frames that are equal */
} toliman_linear_training;

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
toliman_linear_train_components(toliman_linear_components *components, const toliman_linear_train_options *options,
                                toliman_linear_training *report) TOLIMAN_NOEXCEPT;

/* Series of component 0, 1, ... into values[frames], and its share of the frames' sum of squares about their mean
 * (atoms are not orthogonal: their shares need not add up); either may be NULL. In the units of the (binned) residuals:
 * of PCA the mean square is the eigenvalue of the covariance matrix sum x x^T/frames. TOLIMAN_E_STATE before training,
 * TOLIMAN_E_RANGE for a component beyond those trained. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_series(const toliman_linear_components *components,
                                                                        uint32_t component, double *values,
                                                                        double *share) TOLIMAN_NOEXCEPT;

/* Facts of a collection. Since 0.1. */
typedef struct toliman_linear_components_info {
    uint32_t struct_size; /* in: sizeof(toliman_linear_components_info) */
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
} toliman_linear_components_info;

/* Fills *out; out->struct_size must be set. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_components_info(
    const toliman_linear_components *components, toliman_linear_components_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
