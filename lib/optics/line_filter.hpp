// Filters along one axis that integrate over pixels and blur, on point samples of a band-limited image.
#pragma once
#include <vector>

#include "kernels/shift.hpp"
#include "optics/propagate.hpp"
#include "optics/smear.hpp"

namespace toliman::optics {

constexpr double kSampleRounding = 1e-15; // of the filtered samples, relative to the peak

// What a filter does to point samples.
struct Blur {
    bool integrated = false; // over the area of a square pixel
    Jitter jitter;           // px^2
    double pixel = 1;        // side of a pixel, in units of the distance of the filtered samples
    kernels::Window window;  // divides by its transform, for samples that are interpolated; no taps: none
    Path path;

    bool any() const noexcept { return integrated || jitter.any() || window.taps > 0 || !path.nodes.empty(); }
};

// Part of a path's transfer function along one axis: the sum of weight cos(2 pi f at) over nodes, or of the sines if
// odd; 1 without nodes.
struct LinePath {
    std::vector<Path::Node> nodes;
    bool odd = false;
};

// Symmetric, or antisymmetric if odd.
struct LineFilter {
    std::vector<double> taps; // from the middle outwards
    bool odd = false;
    double error = 0; // twice the largest error of the transfer function inside the image's band
    double gain = 0;  // of the rounding of samples: root of the sum of squared taps, times the window's transform
};

// g_m (pixel.cpp) at a frequency in cycles per sample, times that of a path, over the transform of the window; m = 0 is
// H. Of a blur with this variance (px^2) along the axis.
class TransferFunction {
  public:
    TransferFunction(const Blur &blur, double variance, size_t m, const LinePath &path, size_t oversampling);

    double operator()(double frequency) const noexcept { return box(frequency) * gaussian(frequency); }
    double box(double frequency) const noexcept;      // the part of pixel, path and window,
    double gaussian(double frequency) const noexcept; // and that of the jitter,
    double kernel(double distance) const noexcept;    // whose inverse transform this is, at a distance in samples
    double weight(double frequency) const noexcept;   // of an error at this frequency
    double largest(double cutoff) const noexcept;     // magnitude at frequencies up to the cutoff, with the weight
    TransferFunction without_jitter() const noexcept;

    bool odd() const noexcept { return has_odd_kernel() != path_->odd; }
    bool has_odd_kernel() const noexcept { return m_ % 2 == 1; }
    double jitter() const noexcept { return jitter_; } // standard deviation, samples
    size_t order() const noexcept { return m_; }

  private:
    const Blur *blur_;
    const LinePath *path_;
    double finer_, width_, jitter_, step_; // width_: side of a pixel in samples
    size_t m_;
    double log_factorial_ = 0; // of m
};

// The shortest filter found whose error, counted twice because a filter acts along both axes, is within the accuracy on
// images without frequencies above `cutoff` cycles per sample; else the most accurate one.
LineFilter make_line(const TransferFunction &transfer, double cutoff, double accuracy);

} // namespace toliman::optics
