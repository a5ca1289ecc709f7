// The distribution of the places of a sum of frames: cumulants, moments, and its effect on the spectrum of an image.
#pragma once
#include <array>
#include <complex>
#include <cstddef>

#include "frame/spread.hpp"

namespace toliman::fit {

constexpr size_t kSpreadOrder = 6, kSpreadTerms = kCumulants + 6;

// Power series in two variables up to order kSpreadOrder: terms x^a y^b at term_of(a, b). Exact up to rounding.
using Series = std::array<long double, kSpreadTerms>;
constexpr size_t term_of(size_t a, size_t b) noexcept {
    return (a + b) * (a + b + 1) / 2 + b;
}
// Cumulants k_ab of a distribution from its moments E[x^a y^b], and moments from cumulants, in the order of Series.
Series cumulants_of(const Series &moments) noexcept;
Series moments_of(const Series &cumulants) noexcept;

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
