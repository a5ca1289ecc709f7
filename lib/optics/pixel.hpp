// Integration over pixels, Gaussian jitter and motion within an exposure, as short filters on point samples of the
// image.
#pragma once
#include <array>
#include <vector>

#include "optics/line_filter.hpp"

namespace toliman::optics {

// The sum over terms of a filter along x (columns) times one along y. One term, unless the jitter in x and in y is
// correlated, or the image moves along both axes within an exposure.
struct PixelFilter {
    size_t oversampling = 1; // point samples per pixel and axis
    std::vector<std::array<LineFilter, 2>> terms;
    double error = 0; // of the image, relative to its peak: of the transfer function inside its band, and rounding

    bool empty() const noexcept { return terms.empty(); }
    size_t margin() const noexcept; // samples beyond the pixels' centres
    size_t taps() const noexcept;   // of all filters together
};

// The shortest filter found with error <= accuracy on images without spatial frequencies above `cutoff` cycles per
// filtered sample; else the most accurate one. Empty if there is no blur.
PixelFilter make_filter(double cutoff, const Blur &blur, double accuracy);

// The grid of point samples that a filter needs for `pixels`.
Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept;

// The adjoint of filtered(): spreads weights of the pixels over the samples of sampling_grid(pixels).
Buffer<double> spread(const Buffer<double> &weights, const Grid &pixels, const PixelFilter &filter);

// Filters an image on sampling_grid(pixels) and returns the values at the pixels.
Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter);

} // namespace toliman::optics
