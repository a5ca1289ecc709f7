// Nuisance functions: known functions of each sample, whose coefficients are fitted with the mean at every frequency.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/bytes.hpp"
#include "base/quad.hpp"
#include "period/stream/exact_sum.hpp"

namespace toliman::period {

constexpr size_t kMaxColumns = 32, kMaxFunctions = 1 + kMaxColumns; // trend and columns: kMaxColumns together
constexpr int32_t kMaxTrend = 8;

// K = 1 + trend + columns functions: 1, the Chebyshev polynomials T_1 ... T_trend of the time on [start, end], and
// values that come with each sample, divided by their bound. The coefficient of each may have a Gaussian prior of mean
// 0.
struct Basis {
    int32_t trend = 0, columns = 0;
    double start = 0, end = 0;                        // span of the trend
    std::array<double, kMaxColumns> bound = {};       // largest |value| of each column
    std::array<double, kMaxFunctions> precision = {}; // 1/sigma^2 of each prior, in the caller's units; 0: free

    // Whether anything but the mean is fitted, or the mean has a prior.
    bool any() const noexcept { return trend > 0 || columns > 0 || precision[0] > 0; }
    bool has_priors() const noexcept {
        return std::any_of(precision.begin(), precision.end(), [](double one) { return one > 0; });
    }
    size_t functions() const noexcept { return 1 + static_cast<size_t>(trend) + static_cast<size_t>(columns); }
    size_t first_column() const noexcept { return 1 + static_cast<size_t>(trend); }
    void check() const;
    // Number that function `f` is divided by.
    double unit(size_t f) const noexcept { return f < first_column() ? 1 : bound[f - first_column()]; }

    // The part of the state bytes that follows the numbers of functions.
    void save(ByteWriter &out) const;
    void load(ByteReader &in); // of this number of functions
    size_t saved_size() const noexcept { return 8 * (2 + static_cast<size_t>(columns) + functions()); }
};

// Values of the functions at a sample, as unevaluated sums. values [0] is left to the caller.
struct BasisValues {
    double high[kMaxFunctions], low[kMaxFunctions];
};

// Given     the time from `offset`, high + low, and the sample's values [columns]
// Computed  values 1 ... K - 1: Chebyshev polynomials to 1e-32, with the same bits on every machine
void evaluate(const Basis &basis, double offset, double high, double low, const double *columns,
              BasisValues &values) noexcept;

// Position of a time in the span of the trend: -1 at the start, 1 at the end.
Quad position(const Basis &basis, double offset, double high, double low) noexcept;

// Exact sums of products of the functions with each other and with y. The sums of 1 are those of Totals.
class BasisSums {
  public:
    explicit BasisSums(size_t functions);
    // Adds w b_i b_j and w y b_j, exact but for products below 1e-32 of the weight.
    void add(double weight, double y_high, double y_low, const BasisValues &values) noexcept;
    void add(const BasisSums &other) noexcept;
    void reset() noexcept;

    size_t functions() const noexcept { return functions_; }
    // sum w b_i b_j, j <= i, i >= 1.
    const ExactSum &product(size_t i, size_t j) const noexcept { return sums_[row(i) + j]; }
    // sum w y b_i, i >= 1.
    const ExactSum &with_y(size_t i) const noexcept { return sums_[row(i) + i + 1]; }
    // All sums: for i = 1 ... K - 1 the products with j = 0 ... i, then the one with y.
    Buffer<ExactSum> &all() noexcept { return sums_; }
    const Buffer<ExactSum> &all() const noexcept { return sums_; }
    // Whether no sum violates |w b_i b_j| <= W and the Cauchy-Schwarz inequality, up to `slack`.
    bool consistent(Quad weight, Quad wyy, Quad slack) const noexcept;
    static size_t count(size_t functions) noexcept { return (functions - 1) * (functions + 4) / 2; }

  private:
    static size_t row(size_t i) noexcept { return count(i); }
    size_t functions_;
    Buffer<ExactSum> sums_;
};

} // namespace toliman::period
