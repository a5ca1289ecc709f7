// Integration over pixels and Gaussian jitter, as short filters on point samples of the image.
#pragma once
#include <array>
#include <vector>

#include "kernels/shift.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

// A filter along one axis: symmetric, or antisymmetric if odd.
struct LineFilter {
    std::vector<double> taps; // from the middle outwards
    bool odd = false;
    double error = 0; // twice the largest error of the transfer function inside the image's band
};

// The sum over terms of a filter along x (columns) times one along y. One term, unless the jitter in x and in y is
// correlated.
struct PixelFilter {
    size_t oversampling = 1; // point samples per pixel and axis
    std::vector<std::array<LineFilter, 2>> terms;
    double error = 0; // largest error of the transfer function inside the image's band, both axes together

    bool empty() const noexcept { return terms.empty(); }
    size_t margin() const noexcept; // samples beyond the pixels' centres
    size_t taps() const noexcept;   // of all filters together
};

// What the filter does to point samples.
struct Blur {
    bool integrated = false; // over the area of a square pixel
    Jitter jitter;           // px^2
    double pixel = 1;        // side of a pixel, in units of the distance of the filtered samples
    kernels::Window window;  // divides by its transform, for samples that are interpolated; no taps: none

    bool any() const noexcept { return integrated || jitter.any() || window.taps > 0; }
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
