/* libtoliman, goodness of fit: whether the residuals of a fit are those of its noise.
 *
 * Data flow
 *
 *   fit of a frame, of many frames, of a series -> chi_square, chi_square_sigma, largest_residual -> goodness
 *
 * Members of results that compare a model with data; NaN if unknown:
 *
 *   chi_square        sum of squared residuals over their variances, per degree of freedom; 1 if the model is right
 *   chi_square_sigma  its standard deviation, if model and variances are right
 *   largest_residual  largest |residual| over its standard deviation
 *   goodness          TOLIMAN_GOODNESS_... of chi_square: POOR or TOO_GOOD beyond the quantiles of 6 (frames,
 *                     calibrations) or 4 (series) Gaussian standard deviations */
#ifndef TOLIMAN_GOODNESS_H
#define TOLIMAN_GOODNESS_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Verdicts.
 *   UNKNOWN   no chi_square
 *   GOOD      the noise explains the residuals
 *   POOR      damaged data, an effect missing in the model, or too small standard deviations: results may be wrong
 *   TOO_GOOD  too large standard deviations, as in a unit with fewer counts than photons */
#define TOLIMAN_GOODNESS_UNKNOWN 801
#define TOLIMAN_GOODNESS_GOOD 802
#define TOLIMAN_GOODNESS_POOR 803
#define TOLIMAN_GOODNESS_TOO_GOOD 804

/* Goodness of fit of one frame against the linear model of a template or network (linear.h, cae.h).
 *
 * Bad pixels are cosmic rays, hot and dead pixels: residuals above 6 standard deviations, more for few photons. One in
 * 8,000 undamaged frames of 256x256 has one. A value is estimated from the other pixels alone
 * (promise: bad-pixels-are-left-out). If more than 30 pixels exceed the limit, all are used, bad_pixels is 0, and
 * goodness is POOR (promise: wrong-models-are-not-cleaned). */
typedef struct toliman_frame_goodness {
    uint32_t struct_size;
    int32_t goodness;
    double chi_square; /* +infinity if it overflows */
    double chi_square_sigma;
    double largest_residual;
    uint32_t bad_pixels; /* left out */
    uint32_t reserved;
} toliman_frame_goodness;
#define TOLIMAN_FRAME_GOODNESS_INIT TOLIMAN_INIT(toliman_frame_goodness)

TOLIMAN_END_DECLS

#endif
