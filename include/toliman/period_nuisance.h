/* libtoliman, periodogram: nuisance functions, fitted with the mean at each frequency: a trend (polynomial in time),
 * and columns, values that come with each sample, such as the derivative of the separation by an element of the orbit
 * (toliman_sky_set_columns). toliman_period_options declares them.
 *
 * Data flow (toliman_period_...)
 *
 *   options.trend, .columns -> create -> toliman_period <- push, push_many                 <- samples (trend only)
 *                                                       <- push_samples, retract_samples   <- samples, rows[n][columns]
 *                                        query_coefficients; all queries of period.h and period_fap.h
 *
 * Model        y = c_0 + sum over j of c_j b_j + a cos(2 pi f t) + b sin(2 pi f t), with K - 1 <= 32 functions b_j: the
 *              Chebyshev polynomials T_1 ... T_trend, then the columns.
 * Power        1 - R/R_H, with the residual sums of squares R of the model and R_H of mean and functions. Do not
 *              subtract a fitted trend before: that removes a part of the signal.
 * Priors       A coefficient may have a Gaussian prior of mean 0 and standard deviation s_j: (c_j/s_j)^2 is added to R
 *              and R_H. Sigmas must then be absolute.
 * FAP          N - K degrees of freedom; K counts the mean and the functions in use without a prior. Queries of peaks,
 *              models and FAPs need K + 4 samples.
 * Exactness    With functions, too, any order gives the same bits; retractions, and merges of equal digests, are exact
 *              (promise: functions-keep-exactness). Merges of other digests return TOLIMAN_E_MISMATCH.
 * Accuracy     The power with a trend has an error of 1e-12 if the samples cover its span
 *              (promise: trend-power-has-twelve-digits) and 0.3 cycles, for K up to 8. It is also 1e-12 if they cover a
 *              tenth of the span, for K up to 6, and 1e-9 if they cover 3 %.
 * In use       A function that the samples do not determine (the others leave less than 2^-40 of it) is left out until
 *              they do, the highest order of the trend first: see toliman_period_info.functions. */
#ifndef TOLIMAN_PERIOD_NUISANCE_H
#define TOLIMAN_PERIOD_NUISANCE_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Writes the coefficients of mean and nuisance functions, fitted with the sinusoid at grid frequency k.
 *   count         1 + trend + columns
 *   coefficients  [count], units of y, or of y per unit of the function; 0 if not in use
 *   errors        [count], standard errors, scaled by the residual; +infinity if not in use; may be NULL
 * Errors: as toliman_period_query_model; TOLIMAN_E_STATE without nuisance functions and priors. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_coefficients(const toliman_period *period, int64_t k,
                                                                                size_t count, double *coefficients,
                                                                                double *errors) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
