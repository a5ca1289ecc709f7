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
 * A number that is unknown is NaN. The limits of chi_square are the two quantiles of a chi-square distribution with
 * 2/chi_square_sigma^2 degrees of freedom that are as improbable as a Gaussian deviation of 6 standard deviations for
 * frames and calibrations, of which a mission has a million, and of 4 for series, of which it has one.
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
 *             a unit with fewer counts than photons (DN). Where the model does not fit the fluxes, these are POOR */
#define TOLIMAN_GOODNESS_UNKNOWN 801
#define TOLIMAN_GOODNESS_GOOD 802
#define TOLIMAN_GOODNESS_POOR 803
#define TOLIMAN_GOODNESS_TOO_GOOD 804

/* Goodness of fit of one frame against the linear model of a template or network (linear.h, cae.h), without its bad
 * pixels.
 *
 * Bad pixels are cosmic rays, hot and dead pixels. A pixel of V expected electrons, read noise included, is bad if its
 * residual x after the fit, in standard deviations, has x^2 > 36 (1 + max(x, 0)/(3 sqrt(V))), times chi_square of the
 * other pixels if that is above 1: 1 of 8,000 undamaged frames of 256x256 has such a pixel. A value is estimated from
 * the other pixels alone (promise: bad-pixels-are-left-out). If more than 30 pixels exceed the limit, the model is
 * wrong: all are used, bad_pixels is 0, and goodness is POOR (promise: wrong-models-are-not-cleaned). */
typedef struct toliman_frame_goodness {
    uint32_t struct_size;    /* in: sizeof(toliman_frame_goodness) */
    int32_t goodness;        /* verdict on chi_square, TOLIMAN_GOODNESS_... */
    double chi_square;       /* per degree of freedom; +infinity if it overflows */
    double chi_square_sigma; /* standard deviation of chi_square, if the model is right */
    double largest_residual; /* largest |residual| over its standard deviation */
    uint32_t bad_pixels;     /* number of pixels that were left out */
    uint32_t reserved;
} toliman_frame_goodness;
#define TOLIMAN_FRAME_GOODNESS_INIT TOLIMAN_INIT(toliman_frame_goodness)

TOLIMAN_END_DECLS

#endif
