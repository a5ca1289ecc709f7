// C interface of filters along a line.
#include <algorithm>

#include "optics/line_filter.hpp"

using namespace toliman::optics;

// Of a Gaussian of `sigma` samples, term m of the expansion in a covariance of which it is the variance, over a pixel
// of one sample if integrated. Writes taps from the middle outwards; returns their number, 0 if there are more than
// `most`.
extern "C" size_t shim_line_filter(double cutoff, double sigma, size_t m, int integrated, double accuracy, size_t most,
                                   double *taps, double *error) {
    Blur blur;
    blur.integrated = integrated != 0;
    blur.jitter.xx = blur.jitter.yy = blur.jitter.xy = sigma * sigma;
    const LineFilter line = make_line(TransferFunction(blur, sigma * sigma, m, {}, 1), cutoff, accuracy);
    if (line.taps.size() > most)
        return 0;
    std::copy(line.taps.begin(), line.taps.end(), taps);
    *error = line.error;
    return line.taps.size();
}
