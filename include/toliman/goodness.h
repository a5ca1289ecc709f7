/* libtoliman, goodness of fit: whether the residuals of a fit are those of its noise.
 *
 * Data flow
 *
 *   fit of a frame, of many frames, of a series -> chi_square, chi_square_sigma, largest_residual -> goodness
 *
 * Every result that compares a model with data has these four members:
 *
 *   chi_square        sum of squared residuals over their variances, per degree of freedom; 1 if the model is right
 *   chi_square_sigma  standard deviation of chi_square, if the model and the variances are right
 *   largest_residual  largest |residual| over its standard deviation
 *   goodness          verdict TOLIMAN_GOODNESS_...
 *
 * A number that is unknown is NaN. The verdict compares chi_square with the quantiles of a chi-square distribution of
 * 2/chi_square_sigma^2 degrees of freedom that a Gaussian exceeds at 6 standard deviations for frames and calibrations,
 * of which a mission has a million, and at 4 for series, of which it has one. Both sides count.
 */
#ifndef TOLIMAN_GOODNESS_H
#define TOLIMAN_GOODNESS_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Verdicts of goodness of fit.
 *   UNKNOWN   there is no chi_square
 *   GOOD      the noise explains the residuals
 *   POOR      chi_square is too large: the data are damaged, the model lacks an effect, or the standard deviations are
 *             too small. The standard deviations of the results are too small, and the results may be wrong
 *   TOO_GOOD  chi_square is too small: the standard deviations are too large, for instance because the data are in
 *             another unit (DN instead of photons) */
#define TOLIMAN_GOODNESS_UNKNOWN 801
#define TOLIMAN_GOODNESS_GOOD 802
#define TOLIMAN_GOODNESS_POOR 803
#define TOLIMAN_GOODNESS_TOO_GOOD 804

/* Returns the name of a verdict: "unknown", "good", "poor", "too good"; "?" for another number. Static text. Since 0.2.
 */
TOLIMAN_API const char *toliman_goodness_name(int32_t goodness) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
