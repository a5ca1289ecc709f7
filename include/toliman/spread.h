/* libtoliman, spread: a frame that is the sum of many short ones, between which the stars moved.
 *
 * Data flow
 *
 *   coadd.h -> toliman_spread -> toliman_frame -> track.h; toliman_fit_prediction -> fit.h */
#ifndef TOLIMAN_SPREAD_H
#define TOLIMAN_SPREAD_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Number of cumulants of order 3 to 6. */
#define TOLIMAN_SPREAD_CUMULANTS 22u

/* Number of the short frames, and distribution of the stars' places in them. Both stars move by the same x and y (px),
 * measured from their mean over the frames; frames are weighted by their light. The scene's jitter within a short frame
 * is added to the spread. A long exposure with known pointing jitter is 1 frame with a spread.
 *
 * With cumulants, the expected sum is exact to order 6: to 1e-6 of its peak for jitter of 0.3 px rms with a normal
 * distribution, and to 1e-3 for any other. Without cumulants (all 0), a normal distribution is assumed. Give them also
 * for normal jitter: 10^5 places drawn from a normal distribution still differ from it by more than photon noise. */
typedef struct toliman_spread {
    uint32_t struct_size;
    uint32_t reserved;
    double frames;                 /* 1 to 1e12; 0 = 1. Light, bias, dark current, the variance of the read noise and
                                      saturation are those of the scene's frame times this number */
    double xx_px2, yy_px2, xy_px2; /* covariance of the places, xx and yy at most 4, xy^2 at most xx yy */
    double cumulants[22];          /* px^3 to px^6: xxx, xxy, xyy, yyy, xxxx, xxxy ... yyyyyy */
} toliman_spread;
#define TOLIMAN_SPREAD_INIT TOLIMAN_INIT(toliman_spread)

TOLIMAN_END_DECLS

#endif
