/* libtoliman, template estimator: the linear fit, which reaches the Cramer-Rao bound and is the reference for the CAE.
 *
 * Data flow (functions toliman_linear_...)
 *
 *   toliman_sim -> create -> toliman_linear -> encode, encode_many -> value, px -> period.h
 *  (options_init)                 |   get_sigma -> its standard deviation, px
 *                              destroy
 */
#ifndef TOLIMAN_LINEAR_H
#define TOLIMAN_LINEAR_H

#include <toliman/base.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Weighted least-squares estimate of the separation of a frame: residual against the scene's reference image,
 * projected on the scene's separation derivative made orthogonal to preprocess.project. Const calls may run on one
 * object from several threads. Since 0.1. */
typedef struct toliman_linear toliman_linear;

/* How an estimator is made. Since 0.2. */
typedef struct toliman_linear_options {
    uint32_t struct_size;
    uint32_t reserved;                  /* 0 */
    const toliman_allocator *allocator; /* for the object's large arrays; NULL: the system's memory */
} toliman_linear_options;
#define TOLIMAN_LINEAR_OPTIONS_INIT TOLIMAN_INIT(toliman_linear_options)

/* Fills *options, which has `size` bytes, with the defaults. Since 0.2. */
TOLIMAN_API void toliman_linear_options_init(toliman_linear_options *options, size_t size) TOLIMAN_NOEXCEPT;

/* Template estimator of a scene; sim is not kept, options may be NULL. TOLIMAN_E_SCENE when the nuisances of
 * preprocess.project leave nothing of the separation's derivative. The caller destroys *out. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_create(const toliman_sim *sim,
                                                                    const toliman_linear_options *options,
                                                                    toliman_linear **out) TOLIMAN_NOEXCEPT;

/* Ends an estimator; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_linear_destroy(toliman_linear *linear) TOLIMAN_NOEXCEPT;

/* Displacement (px) of one frame of counts[rows][stride] (shape of the scene). TOLIMAN_E_ARGUMENT for a non-finite
 * count, with its row and column. Source: Gauss-Markov; equals maximum likelihood to first order. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_encode(const toliman_linear *linear, const double *counts,
                                                                    size_t stride, double *value_px) TOLIMAN_NOEXCEPT;

/* Values of `count` frames of image on `threads` workers (0 = one per processor): the bits of toliman_linear_encode for
 * the same counts, for any number of workers. Unless it is NULL, chi_square[count] becomes the mean square per degree
 * of freedom of what the model leaves of each frame,
 *
 *   |r - sum_k <u_k, r> u_k - value w|^2 / (pixels - K - 1),    r = (counts - reference)/sigma per pixel.
 *
 * u_k are the K images of preprocess.project over sigma, made orthonormal; w is the derivative over sigma, made
 * orthogonal to them. Frames of the scene have 1 with the standard deviation sqrt(2/pixels), or sqrt(sum(2 +
 * 1/m))/pixels where pixels expect few electrons m. Damaged frames have far more, as do systematics that are not
 * projected out; an empty frame has about 0 where both fluxes are projected out. +infinity where it overflows. Errors
 * as of toliman_linear_encode, with the number of the frame; TOLIMAN_E_ARGUMENT for an image of another shape,
 * TOLIMAN_E_RANGE for one that does not fit in memory. Since 0.2. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_encode_many(const toliman_linear *linear,
                                                                         const toliman_image *image, size_t count,
                                                                         uint32_t threads, double *values_px,
                                                                         double *chi_square) TOLIMAN_NOEXCEPT;

/* Predicted standard deviation (px) of a value: the Cramer-Rao bound with preprocess.project free. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_sigma(const toliman_linear *linear,
                                                                       double *sigma_px) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
