// Integration over pixels and Gaussian jitter, as one short symmetric filter on point samples of the image.
#pragma once
#include <vector>

#include "optics/propagate.hpp"

namespace toliman::optics {

struct PixelFilter {
    size_t oversampling = 1;  // point samples per pixel and axis
    std::vector<double> taps; // from the middle outwards, along either axis; empty = none
    double error = 0;         // largest error of the transfer function inside the image's band, both axes together

    bool empty() const noexcept { return taps.empty(); }
    size_t margin() const noexcept { return empty() ? 0 : taps.size() - 1; }
};

// The shortest filter found with error <= accuracy, for square pixels (integrated) and Gaussian jitter of standard
// deviation jitter_px, on images without spatial frequencies above `cutoff` cycles per px; else the most accurate one.
// Empty for point sampling without jitter.
PixelFilter make_filter(double cutoff, bool integrated, double jitter_px, double accuracy);

// The grid of point samples that a filter needs for `pixels`.
Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept;

// Filters an image on sampling_grid(pixels) and returns the values at the pixels.
Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter);

} // namespace toliman::optics
