// Single bad pixels of a frame: cosmic rays, hot and dead pixels, found by their residual against the fitted model.
//
// Method: a pixel with variance V electrons^2 whose residual is x standard deviations is bad if
//     x^2 > L^2 (1 + max(x, 0)/(3 sqrt(V))),   L = 6.
// For Poisson counts the probability of a larger excess is below exp(-L^2/2) = 1.5e-8 by Bernstein's inequality, for
// any V; for a Gaussian it is 2e-9, 1.3e-4 per frame of 256x256. In the form of the kernels, x (x - tail) > L^2 where
// x > 0, and x^2 > L^2 elsewhere, tail = L^2/(3 sqrt(V)).
// Where the model lacks an effect, the limit is that many times the scatter of all pixels that are not bad: L^2 is
// multiplied by their reduced chi-square, if that is above 1. A bad pixel biases the fit, so that others exceed the
// limit, too: those above half of the largest residual are left out at once, then the model is fitted again. If more
// than kMostBadPixels exceed the limit, the model is wrong, not the pixels: all are used. Reference: Boucheron, Lugosi,
// Massart 2013, Concentration Inequalities, section 2.8.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/goodness.hpp"

namespace toliman {

constexpr size_t kMostBadPixels = 30;
constexpr double kBadPixelSigmas = 6, kBadPixelLimit = kBadPixelSigmas * kBadPixelSigmas,
                 kBadPixelTail = kBadPixelLimit / 3; // over sqrt(V)

// What a residual exceeds the limit by; bad if it is above kBadPixelLimit.
inline double excess_of(double residual, double tail) noexcept {
    return residual * (residual - (residual > 0 ? tail : 0));
}

// What the variances of a frame of counts tell of its pixels.
struct PixelNoise {
    PixelNoise() = default;
    // Expected counts and their variances, infinite where a pixel is not used.
    PixelNoise(const Buffer<double> &reference, const Buffer<double> &variance);

    size_t used = 0;           // pixels
    double inverse_counts = 0; // sum of 1/V, V in electrons^2
    Buffer<double> tail;       // kBadPixelTail / sqrt(V) of each pixel
};

// The goodness of fit of a frame without its bad pixels.
struct FrameGoodness : Goodness {
    size_t bad_pixels = 0;
};

// Of the fit of a frame without `bad_pixels`. A chi-square that overflowed is infinite, as is a NaN. few_bad: false if
// more than kMostBadPixels pixels exceed the limit, which makes the fit poor.
FrameGoodness frame_goodness(double chi_square, double sigma, double largest, size_t bad_pixels, bool few_bad) noexcept;

// Calls visit(pixel) for a pixel of a frame and, if it mixes with its neighbours, for the eight around it.
template <class Visit> void visit_mixed(size_t pixel, size_t rows, size_t cols, bool mixes, const Visit &visit) {
    const size_t r = pixel / cols, c = pixel % cols, reach = mixes ? 1 : 0;
    for (size_t y = r - std::min(r, reach); y <= std::min(r + reach, rows - 1); y++)
        for (size_t x = c - std::min(c, reach); x <= std::min(c + reach, cols - 1); x++)
            visit(y * cols + x);
}

// Bad pixels of one frame, in the order in which they were found.
class BadPixels {
  public:
    size_t count() const noexcept { return count_; }
    size_t operator[](size_t i) const noexcept { return at_[i]; }
    bool has(size_t pixel) const noexcept { return std::find(begin(), end(), pixel) != end(); }
    const size_t *begin() const noexcept { return at_.data(); }
    const size_t *end() const noexcept { return at_.data() + count_; }
    void clear() noexcept { count_ = 0; }

    enum class Found { none, some, too_many };
    // Adds the pixels below `pixels` whose excess(i), of the form of excess_of(), is above the limit, and above a
    // quarter of the largest one: half of the largest residual. square, freedom: the sum of squared residuals of the
    // fit, and its degrees of freedom.
    template <class Excess>
    Found add_largest(size_t pixels, double square, double freedom, const Excess &excess) noexcept {
        double largest = kBadPixelLimit;
        for (size_t i = 0; i < pixels; i++)
            if (const double found = excess(i); found > largest && !has(i))
                largest = found;
        if (!std::isfinite(largest))
            return Found::too_many;
        const double least = kBadPixelLimit * std::fmax(1, square / freedom);
        if (!(largest > least))
            return Found::none;
        const double limit = std::fmax(least, 0.25 * largest);
        for (size_t i = 0; i < pixels; i++)
            if (excess(i) > limit && !has(i) && !add(i))
                return Found::too_many;
        return Found::some;
    }

    // False if there are kMostBadPixels already.
    bool add(size_t pixel) noexcept {
        if (count_ == kMostBadPixels)
            return false;
        at_[count_++] = pixel;
        return true;
    }

  private:
    std::array<size_t, kMostBadPixels> at_ = {};
    size_t count_ = 0;
};

} // namespace toliman
