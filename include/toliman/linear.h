/* libtoliman, template estimator: the linear fit, which reaches the Cramer-Rao bound and is the reference for the CAE.
 *
 * Data flow (functions toliman_linear_...)
 *
 *   toliman_sim -> create -> toliman_linear -> encode -> value, px -> period.h
 *                                 |   get_sigma -> its standard deviation, px
 *                              destroy
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

TOLIMAN_END_DECLS

#endif
