/* libtoliman, components: principal components and sparse dictionaries of frames, the classical baselines that have
 * no knowledge of the signal.
 *
 * Data flow (functions toliman_components_...)
 *
 *   toliman_sim -> create -> toliman_components <- push <- frames
 *                                  |
 *                                train -> get_series -> one value per frame -> period.h
 *                                get_info
 *                                destroy
 */
#ifndef TOLIMAN_COMPONENTS_H
#define TOLIMAN_COMPONENTS_H

#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Collection of frames of a scene and their components. Each component gives one value per frame, in the order in which
 * the frames were pushed. */
typedef struct toliman_components toliman_components;

/* Options of a collection. */
typedef struct toliman_components_options {
    uint32_t struct_size;
    int32_t raw;  /* 0 or 1: residuals (counts - reference)/sigma, with preprocess.project projected out, or counts */
    uint32_t bin; /* sums blocks of bin x bin pixels before whitening; must be a divisor of rows and of columns; 0
                          = 1 */
    uint32_t capacity; /* largest number of frames, in [2, 16384]; 0 = number of frames of the scene's cadence */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    toliman_log_fn log;                 /* receives warnings about preprocess.project; may be NULL */
    void *log_data;
} toliman_components_options;
#define TOLIMAN_COMPONENTS_OPTIONS_INIT TOLIMAN_INIT(toliman_components_options)

/* Creates an empty collection for frames of a scene and allocates the memory of all its frames: 4 bytes per binned
 * pixel, as residuals are stored in float32 with a relative error of at most 6e-8. options may be NULL. The simulator
 * is not needed afterwards. The caller destroys *out. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_create(const toliman_sim *sim,
                                                                        const toliman_components_options *options,
                                                                        toliman_components **out) TOLIMAN_NOEXCEPT;

/* Destroys a collection. NULL is allowed. */
TOLIMAN_API void toliman_components_destroy(toliman_components *components) TOLIMAN_NOEXCEPT;

/* Adds `count` frames of image in order, or none if one is refused (promise: components-take-all-or-none). Discards
 * trained components.
 * Errors: TOLIMAN_E_ARGUMENT for a non-finite count, naming its frame, row and column, and for another shape than that
 * of the scene; TOLIMAN_E_RANGE for a count beyond the range of float32, and for an image larger than the address
 * space; TOLIMAN_E_CAPACITY if the collection becomes full. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_push(toliman_components *components,
                                                                      const toliman_image *image,
                                                                      size_t count) TOLIMAN_NOEXCEPT;

/* Methods of toliman_components_train. */
#define TOLIMAN_COMPONENTS_PCA 401        /* principal component analysis */
#define TOLIMAN_COMPONENTS_DICTIONARY 402 /* sparse dictionary learning */

/* Training options. */
typedef struct toliman_components_train_options {
    uint32_t struct_size;
    int32_t method;               /* TOLIMAN_COMPONENTS_..., 0 = PCA */
    uint32_t components;          /* number of components, in [1, 64] and fewer than frames; 0 = 1 */
    uint32_t threads;             /* worker threads, 0 = one per processor */
    uint32_t iterations;          /* dictionary: largest number of iterations; 0 = 200 */
    uint32_t reserved;            /* 0 */
    double lambda;                /* dictionary: lambda of toliman_components_train, in (0, 1e6]; 0 = 1 */
    uint64_t seed;                /* dictionary: seed of the random initial atoms */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_components_train_options;
#define TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT TOLIMAN_INIT(toliman_components_train_options)

/* Training result. */
typedef struct toliman_components_training {
    uint32_t struct_size; /* in: sizeof(toliman_components_training) */
    uint32_t iterations;  /* dictionary: number of iterations; 0 for PCA */
    int32_t converged;    /* 1: the last iteration improved the objective by less than 1e-5 of the total improvement;
                             0: stopped by the limit on iterations */
    uint32_t reserved;
    double objective; /* dictionary: objective / objective without atoms, 0 ... 1; 0 for PCA and for identical frames */
} toliman_components_training;
#define TOLIMAN_COMPONENTS_TRAINING_INIT TOLIMAN_INIT(toliman_components_training)

/* Finds components of the pushed frames, after subtracting their mean. Writes the result to *report. options and
 * report may be NULL.
 *   PCA         leading eigenvectors. Value k of series j is the projection of frame k on principal image j.
 *   DICTIONARY  codes a and atoms D with |D_j| <= 1 that minimise the sum of |x - D a|^2/2 + lambda s |a|_1, where s
 *               is the rms of all pixels of the frames. Starts from random atoms in the span of the frames. Finds a
 *               local minimum. Sorted by energy.
 * The largest element of a series, in magnitude, is positive. Identical frames give series of zeros. Equal
 * eigenvalues give an arbitrary basis of their space. The same frames, options and seed give the same bits
 * (promise: components-repeat-their-bits); the last bits of PCA depend on the threads of OpenBLAS.
 *
 * The inner products of all pairs of frames, which dominate the run time, are kept for the next training, 8 bytes
 * each, until the next push.
 * Errors: TOLIMAN_E_STATE for fewer than components + 1 frames; TOLIMAN_E_CANCELLED. Components of an earlier training
 * then remain (promise: cancelled-components-remain). Source: Jolliffe (2002); Mairal, Bach, Ponce, Sapiro (2009), with
 * all frames in one batch. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_train(toliman_components *components, const toliman_components_train_options *options,
                         toliman_components_training *report) TOLIMAN_NOEXCEPT;

/* Writes the series of a component, counted from 0.
 *   values  [frames], in units of the (binned) residuals; for PCA the mean square is the eigenvalue of the covariance
 *           matrix sum x x^T/frames. May be NULL
 *   share   share of the component in the sum of squares of the frames about their mean. Shares of a dictionary need
 *           not add up to 1, because atoms are not orthogonal. May be NULL
 * Errors: TOLIMAN_E_STATE before training; TOLIMAN_E_RANGE for a component that was not trained. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_components_get_series(const toliman_components *components,
                                                                            int64_t component, double *values,
                                                                            double *share) TOLIMAN_NOEXCEPT;

/* Properties of a collection. */
typedef struct toliman_components_info {
    uint32_t struct_size; /* in: sizeof(toliman_components_info) */
    int32_t raw;          /* as in the options */
    uint32_t bin;         /* as in the options */
    uint32_t projected;   /* number of nuisance images projected out; 0 if raw */
    int64_t capacity;     /* largest number of frames */
    int64_t frames;       /* number of frames pushed */
    int64_t pixels;       /* pixels of a frame after binning */
    int64_t components;   /* number of trained components; 0 before training */
    double crb_px;        /* Cramer-Rao bound of a binned frame with the projected nuisances unknown; NaN if raw */
    /* Detection threshold of PCA, in the limit of many frames and pixels: smallest amplitude (px) of a sinusoidal
     * separation that the leading principal component responds to. For N frames of p independent pixels with unit
     * noise, where p = pixels - projected, the eigenvalue of the signal is l = A^2/(2 crb^2). It must exceed
     * sqrt(p/N); hence A = crb sqrt(2 sqrt(p/N)) (Baik, Ben Arous, Peche 2005). Above the threshold, the squared
     * cosine between principal image and signal is (1 - p/N/l^2)/(1 + p/N/l) (Paul 2007), and the squared correlation
     * between series and signal is (1 - p/N/l^2)/(1 + 1/l) (Benaych-Georges and Nadakuditi 2012). +infinity without
     * frames, NaN if raw. */
    double threshold_px;
} toliman_components_info;
#define TOLIMAN_COMPONENTS_INFO_INIT TOLIMAN_INIT(toliman_components_info)

/* Writes the properties of a collection to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_components_get_info(const toliman_components *components, toliman_components_info *out) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
