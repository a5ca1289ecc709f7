// Streaming periodogram: the exact sums of all samples pushed so far.
#pragma once
#include <cstdint>

#include "base/buffer.hpp"
#include "kernels/push.hpp"
#include "period/exact_sum.hpp"

namespace toliman::period {

// Frequencies f0 + k df, k < nf, and everything else that the bits of the sums depend on.
struct Grid {
    double f0 = 0, df = 0;
    int64_t nf = 0;
    bool fixed_mean = false;
    double time_offset = 0, value_offset = 0;
    double value_bound = 0x1p20;
    double sigma_floor = 1;

    void check() const;
    uint64_t digest() const;
    double last() const noexcept { return f0 + df * static_cast<double>(nf - 1); }
};

// Sums of one frequency in units of one sample of weight 1; values in units of value_bound.
struct SumsAt {
    long double c1, s1, c2, s2, yc, ys;
};

// Sums that no frequency enters. W and Wy are sums of the same quantised terms as C1 and YC at f = 0.
struct Totals {
    int64_t count = 0;
    int64_t weight = 0, weight_high = 0;       // quantised at 2^-50, carry-save as in kernels/push.hpp
    int64_t value = 0, value_high = 0;         // w y, the same
    int64_t value_low = 0, value_low_high = 0; // its remainder at 2^-100
    ExactSum w, wy, wyy, wt, wtt;              // exact: w, w y, w y^2, w t, w t^2 (offsets subtracted)
};

class Stream {
  public:
    explicit Stream(const Grid &grid);

    // Fails with the sample's number (when index >= 0) unless it can be pushed.
    void check(double t, double y, double sigma, int64_t index) const;
    // Takes a checked sample. Allocates nothing.
    void push(double t, double y, double sigma) noexcept;
    void reset() noexcept;

    const Grid &grid() const noexcept { return grid_; }
    const Totals &totals() const noexcept { return totals_; }
    SumsAt sums(int64_t k) const noexcept;
    long double weight() const noexcept; // W
    long double mean() const noexcept;   // Wy/W, in units of value_bound
    // Variance of the values about their mean, in units of value_bound squared; 0 if they are constant.
    long double spread() const noexcept;
    long double time_variance() const noexcept;

    // Bytes of lib/FORMATS.md, "TLMP".
    std::vector<uint8_t> save() const;
    static Stream load(const void *bytes, size_t size);

  private:
    size_t padded() const noexcept { return blocks_ * kernels::kBlock; }
    void fold() noexcept;

    Grid grid_;
    Totals totals_;
    size_t blocks_;
    int pending_ = 0;
    Buffer<int64_t> lo_, hi_; // [kSums][padded]
    Buffer<double> anchors_;
};

} // namespace toliman::period
