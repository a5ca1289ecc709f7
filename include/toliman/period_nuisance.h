/* libtoliman, periodogram: nuisance functions, fitted with the mean at each frequency.
 *
 * Nuisance functions describe slow variations that are not periodic, and effects that are known up to a factor: a trend
 * (polynomial in time), and columns, values that come with each sample, such as the derivative of the separation by an
 * element of the orbit. They are declared at creation, in toliman_period_options.
 *
 * Data flow (functions toliman_period_...)
 *
 *   options.trend, .columns -> create -> toliman_period <- push, push_many                 <- samples (trend only)
 *                                           |           <- push_samples, retract_samples   <- samples, rows[n][columns]
 *                                           +-> all queries of period.h and period_fap.h
 *                                           +-> query_coefficients          coefficients of the functions
 *
 * Model        y = c_0 + sum over j of c_j b_j + a cos(2 pi f t) + b sin(2 pi f t), with K - 1 <= 32 functions b_j, in
 *              this order: the Chebyshev polynomials T_1 ... T_trend, then the columns.
 * Power        1 - R/R_H, where R_H is the residual of mean and functions instead of that of the mean alone. Do not
 *              subtract a fitted trend before the samples are pushed: that removes a part of the signal.
 * Priors       A coefficient may have a Gaussian prior of mean 0 and standard deviation s_j. (c_j/s_j)^2 is then added
 *              to both residuals; the sigmas of the samples must be absolute.
 * FAP          N - K degrees of freedom, where K counts the mean and the functions in use that have no prior. Queries
 *              of peaks, models and FAPs need K + 4 samples.
 * Exactness    With functions, too, any order gives the same bits, and merges of equal digests and retractions are
 *              exact (promise: functions-keep-exactness). The accumulators are double-limb. Merges of other digests
 *              return TOLIMAN_E_MISMATCH.
 * Accuracy     The power with a trend has an error of 1e-12 if the samples cover its span
 *              (promise: trend-power-has-twelve-digits) and 0.3 cycles (K up to 8), or a tenth of the span (K up to 6);
 *              1e-9 for 3 % of the span.
 * In use       A function that the samples do not determine is left out until they do, the highest order of the trend
 *              first: one of which the others leave less than 2^-40. See functions and free_functions of
 *              toliman_period_info.
 * Source       Zechmeister and Kuerster (2009), A&A 496, 577; Baluev (2008), MNRAS 385, 1279, with general base models.
 *
 * For the errors of the orbit of a binary, toliman_sky_set_columns (sky.h) sets columns, bounds and priors.
 */
#ifndef TOLIMAN_PERIOD_NUISANCE_H
#define TOLIMAN_PERIOD_NUISANCE_H

#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Writes the coefficients of mean and nuisance functions fitted with the sinusoid at grid frequency k to
 * coefficients[count], and their standard errors, scaled by the residual, to errors[count].
 *   count   1 + trend + columns
 *   errors  may be NULL
 * The mean is in units of y, all others in units of y per unit of the function. A function that is not in use has the
 * coefficient 0 and the error +infinity.
 * Errors: as toliman_period_query_model; TOLIMAN_E_ARGUMENT for another count; TOLIMAN_E_STATE if the options declare
 * no nuisance function and no prior. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_period_query_coefficients(const toliman_period *period, int64_t k,
                                                                                size_t count, double *coefficients,
                                                                                double *errors) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
