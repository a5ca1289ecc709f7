/* libtoliman, template estimator: a linear least-squares fit that reaches the Cramer-Rao bound. It is the reference
 * for the autoencoder.
 *
 * Data flow (functions toliman_linear_...)
 *
 *   toliman_sim -> create -> toliman_linear -> encode -> value, px -> period.h
 *                                 |   get_sigma -> standard deviation of a value, px
 *                              destroy
 */
#ifndef TOLIMAN_LINEAR_H
#define TOLIMAN_LINEAR_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Template estimator: weighted least-squares estimate of the displacement (the change of the separation) from one
 * frame. The residual (frame minus reference image) is projected on the derivative image of the separation, after
 * this derivative image has been made orthogonal to the nuisances of preprocess.project. */
typedef struct toliman_linear toliman_linear;

/* Options of an estimator. */
typedef struct toliman_linear_options {
    uint32_t struct_size;
    uint32_t threads;                   /* worker threads of toliman_linear_encode, 0 = one per processor */
    const toliman_allocator *allocator; /* for the large arrays of the object; NULL = malloc */
    toliman_log_fn log;                 /* receives warnings about preprocess.project; may be NULL */
    void *log_data;
} toliman_linear_options;
#define TOLIMAN_LINEAR_OPTIONS_INIT TOLIMAN_INIT(toliman_linear_options)

/* Creates the template estimator of a scene. The simulator is not needed afterwards. options may be NULL. The caller
 * destroys *out. TOLIMAN_E_SCENE if the nuisances of preprocess.project span the derivative by the separation. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_create(const toliman_sim *sim,
                                                                    const toliman_linear_options *options,
                                                                    toliman_linear **out) TOLIMAN_NOEXCEPT;

/* Destroys an estimator. NULL is allowed. */
TOLIMAN_API void toliman_linear_destroy(toliman_linear *linear) TOLIMAN_NOEXCEPT;

/* Estimates the displacements of `count` frames of image, on the threads of the estimator's options; one frame on the
 * calling thread. A value does not depend on the other frames. By the Gauss-Markov theorem it is the best linear
 * unbiased estimate; to first order it equals maximum likelihood. Bad pixels are left out.
 *   values_px  [count], px
 *   goodness   [count], or NULL; struct_size of the first must be set
 * The chi_square of goodness is
 *
 *     |r - sum_k <u_k, r> u_k - value w|^2 / (pixels - K - 1),    r = (counts - reference)/sigma per pixel
 *
 * u_k are the K images of preprocess.project over sigma, orthonormalised; w is the derivative over sigma, orthogonal
 * to them. If both fluxes are projected out, they fit an empty frame perfectly: it is TOO_GOOD.
 * Errors: TOLIMAN_E_ARGUMENT for another shape, and for a non-finite count, naming its row and column, and its frame if
 * there are several; TOLIMAN_E_RANGE for an image larger than the address space. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_encode(const toliman_linear *linear,
                                                                    const toliman_image *image, size_t count,
                                                                    double *values_px,
                                                                    toliman_frame_goodness *goodness) TOLIMAN_NOEXCEPT;

/* Writes the predicted standard deviation of a template's values, px, to *sigma_px
 * (promise: template-scatter-is-the-bound): the Cramer-Rao bound with the nuisances of preprocess.project unknown. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_sigma(const toliman_linear *linear,
                                                                       double *sigma_px) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
