// Method: compares a frame x with its reconstruction y over the network's crop. Both are scaled by the frame's own
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
    const size_t side = preprocess.side, count = preprocess.pixels();
    const Crop crop = preprocess.crop_of(frame);
    Buffer<double> seen(count), reconstructed(image, image + count);
    for (size_t r = 0; r < side; r++)
        std::copy_n(crop.counts.row(r), side, &seen[r * side]);
    const auto [darkest, brightest] = std::minmax_element(seen.begin(), seen.end());
    const double lowest = *darkest, range = *brightest - lowest;
    if (!(range > 0))
        fail(Status::argument, "{counts}: all pixels are %g: must not all be equal", lowest);

    double error = 0, variance = 0;
    for (size_t i = 0; i < count; i++) {
        seen[i] = (seen[i] - lowest) / range;
        reconstructed[i] = (reconstructed[i] - lowest) / range;
        error += (seen[i] - reconstructed[i]) * (seen[i] - reconstructed[i]);
        if (std::isfinite(preprocess.variance[i])) // not a bad pixel
            variance += preprocess.variance[i];
    }
    Buffer<double> scratch(5 * side);
    const auto pixels = static_cast<double>(count);
    const Quality quality = {error / pixels,
                             kernels::mean_ssim(seen.data(), reconstructed.data(), side, side, scratch.data()),
                             variance / pixels / range / range};
    if (!std::isfinite(quality.mmse) || !std::isfinite(quality.mssim) || !std::isfinite(quality.photon_floor))
        fail(Status::range, "{counts}: range = %g: too small compared with the reconstruction: a quality overflows",
             range);
    return quality;
}

} // namespace toliman::cae
