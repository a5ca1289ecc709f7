/* libtoliman, template estimator: a linear least-squares fit that reaches the Cramer-Rao bound, reference for the
 * autoencoder.
 *
 * Data flow (toliman_linear_...)
 *
 *   toliman_sim -> create, destroy -> toliman_linear -> encode -> value, px -> period.h
 *                                                    get_sigma -> standard deviation of a value, px */
#ifndef TOLIMAN_LINEAR_H
#define TOLIMAN_LINEAR_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Weighted least-squares estimator of the displacement (the change of the separation) in one frame, with the nuisances
 * of preprocess.project free. */
typedef struct toliman_linear toliman_linear;

/* Options of an estimator. */
typedef struct toliman_linear_options {
    uint32_t struct_size;
    uint32_t threads;
    const toliman_allocator *allocator;
    toliman_log_fn log; /* receives warnings about preprocess.project */
    void *log_data;
} toliman_linear_options;
#define TOLIMAN_LINEAR_OPTIONS_INIT TOLIMAN_INIT(toliman_linear_options)

/* Creates the template estimator of a scene. TOLIMAN_E_SCENE if the nuisances span the derivative by the separation. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_create(const toliman_sim *sim,
                                                                    const toliman_linear_options *options,
                                                                    toliman_linear **out) TOLIMAN_NOEXCEPT;

/* Destroys an estimator. */
TOLIMAN_API void toliman_linear_destroy(toliman_linear *linear) TOLIMAN_NOEXCEPT;

/* Estimates the displacements of `count` frames of image. A value does not depend on the other frames. Errors: image.h.
 *   values_px  [count]
 *   goodness   [count], or NULL. chi_square is |r - sum_k <u_k, r> u_k - value w|^2 / (pixels - K - 1), where
 *              r = (counts - reference)/sigma per pixel; u_k: the K images of preprocess.project over sigma,
 *              orthonormalised; w: the derivative over sigma, orthogonal to them. If both fluxes are projected out, an
 *              empty frame is TOO_GOOD */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_encode(const toliman_linear *linear,
                                                                    const toliman_image *image, size_t count,
                                                                    double *values_px,
                                                                    toliman_frame_goodness *goodness) TOLIMAN_NOEXCEPT;

/* Writes the predicted standard deviation of a template's values to *sigma_px (promise: template-scatter-is-the-bound):
 * the Cramer-Rao bound with the nuisances unknown. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_get_sigma(const toliman_linear *linear,
                                                                       double *sigma_px) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
