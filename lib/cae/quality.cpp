// Method: compares a frame x with its reconstruction y over the 256x256 crop. Both are scaled by the frame's own
// minimum and range, so that x spans 0 to 1. Then
//     mmse         = mean (x - y)^2
//     mssim        = mean structural similarity (kernels/ssim.hpp)
//     photon_floor = mean variance / range^2
// photon_floor is the expected mmse of the noise-free image, so the best that a reconstruction can be expected to
// reach. A decoder that always returns the reference image comes close to it as well: mmse alone does not show that a
// network has learned the signal.
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "cae/network.hpp"
#include "kernels/ssim.hpp"

namespace toliman::cae {

Quality quality(const Network &network, ImageView<const double> frame, const double *image) {
    const Preprocess &preprocess = network.preprocess();
    const Crop crop = preprocess.crop_of(frame);
    Buffer<double> seen(kPixels), reconstructed(image, image + kPixels);
    for (size_t r = 0; r < kSide; r++)
        std::copy_n(crop.counts.row(r), kSide, &seen[r * kSide]);
    const auto [darkest, brightest] = std::minmax_element(seen.begin(), seen.end());
    const double lowest = *darkest, range = *brightest - lowest;
    if (!(range > 0))
        fail(Status::argument, "{counts}: all pixels are %g: must not all be equal", lowest);

    double error = 0, variance = 0;
    for (size_t i = 0; i < kPixels; i++) {
        seen[i] = (seen[i] - lowest) / range;
        reconstructed[i] = (reconstructed[i] - lowest) / range;
        error += (seen[i] - reconstructed[i]) * (seen[i] - reconstructed[i]);
        if (std::isfinite(preprocess.variance[i])) // not a bad pixel
            variance += preprocess.variance[i];
    }
    Buffer<double> scratch(5 * kSide);
    const double pixels = static_cast<double>(kPixels);
    const Quality quality = {error / pixels,
                             kernels::mean_ssim(seen.data(), reconstructed.data(), kSide, kSide, scratch.data()),
                             variance / pixels / range / range};
    if (!std::isfinite(quality.mmse) || !std::isfinite(quality.mssim) || !std::isfinite(quality.photon_floor))
        fail(Status::range, "{counts}: range = %g: too small compared with the reconstruction: a quality overflows",
             range);
    return quality;
}

} // namespace toliman::cae
