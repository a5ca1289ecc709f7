#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "cae/network.hpp"
#include "kernels/ssim.hpp"

namespace toliman::cae {

Quality quality(const Network &network, ImageView<const double> frame, const double *image) {
    const Preprocess &preprocess = network.preprocess();
    Buffer<double> seen(kPixels), painted(image, image + kPixels);
    for (size_t r = 0; r < kSide; r++)
        std::copy_n(frame.row(preprocess.crop_row + r) + preprocess.crop_col, kSide, &seen[r * kSide]);
    const auto [darkest, brightest] = std::minmax_element(seen.begin(), seen.end());
    const double floor = *darkest, range = *brightest - floor;
    if (!(range > 0))
        fail(Status::argument, "{counts}: all are %g; a frame without contrast has no scale to compare on", floor);

    double error = 0, variance = 0;
    for (size_t i = 0; i < kPixels; i++) {
        seen[i] = (seen[i] - floor) / range;
        painted[i] = (painted[i] - floor) / range;
        error += (seen[i] - painted[i]) * (seen[i] - painted[i]);
        variance += preprocess.variance[i];
    }
    Buffer<double> scratch(5 * kSide);
    const double pixels = static_cast<double>(kPixels);
    const Quality quality = {error / pixels,
                             kernels::mean_ssim(seen.data(), painted.data(), kSide, kSide, scratch.data()),
                             variance / pixels / range / range};
    if (!std::isfinite(quality.mmse) || !std::isfinite(quality.mssim) || !std::isfinite(quality.photon_floor))
        fail(Status::range, "{counts}: span %g, too little beside the image of the network to compare them", range);
    return quality;
}

} // namespace toliman::cae
