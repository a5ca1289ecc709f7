// A frame that is the sum of many short ones, whose places differ: their number, and the distribution of the places.
#pragma once
#include <array>
#include <complex>
#include <cstddef>

namespace toliman::fit {

constexpr size_t kSpreadOrder = 6, kSpreadTerms = 28, kCumulants = kSpreadTerms - 6;

// Power series in two variables up to order kSpreadOrder: terms x^a y^b at term_of(a, b). Exact up to rounding.
using Series = std::array<long double, kSpreadTerms>;
constexpr size_t term_of(size_t a, size_t b) noexcept {
    return (a + b) * (a + b + 1) / 2 + b;
}
// Cumulants k_ab of a distribution from its moments E[x^a y^b], and moments from cumulants, in the order of Series.
Series cumulants_of(const Series &moments) noexcept;
Series moments_of(const Series &cumulants) noexcept;

// Of light, px about its mean.
struct Spread {
    double frames = 1; // that were added
    double xx = 0, yy = 0, xy = 0;
    std::array<double, kCumulants> cumulants = {}; // of order 3 to 6: terms 6 to 27 of Series

    bool moves() const noexcept { return xx != 0 || yy != 0; }
    bool any() const noexcept { return frames != 1 || moves(); }
};

// The mean of exp(-2 pi i (f_x x + f_y y)) over the places: what multiplies the spectrum of an image.
class SpreadTransfer {
  public:
    explicit SpreadTransfer(const Spread &spread) noexcept;
    std::complex<double> operator()(double fx, double fy) const noexcept; // cycles per px

  private:
    double xx_, yy_, xy_;
    std::array<double, kSpreadTerms> terms_; // over the Gaussian
    bool gaussian_;
};

} // namespace toliman::fit
