// From point samples of an image to what pixels collect, and to what jitter blurs. An image is band-limited, so both
// are one short symmetric filter on samples of sufficient density, exact to any accuracy asked for.
#pragma once
#include <vector>

#include "optics/propagate.hpp"

namespace toliman::optics {

struct PixelFilter {
    size_t oversampling = 1;  // point samples per pixel and axis
    std::vector<double> taps; // from the middle outwards, along either axis; empty = none
    double error = 0;         // of the transfer function, where there is light

    bool empty() const noexcept { return taps.empty(); }
    size_t margin() const noexcept { return empty() ? 0 : taps.size() - 1; }
};

// Filter of square pixels (integrated) and Gaussian jitter of a standard deviation in px, for images without content
// beyond `cutoff` cycles per px.
PixelFilter make_filter(double cutoff, bool integrated, double jitter_px, double accuracy);

// The grid of point samples that a filter needs for `pixels`.
Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept;

// Filters an image on sampling_grid(pixels) and keeps what falls on the pixels.
Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter);

} // namespace toliman::optics
