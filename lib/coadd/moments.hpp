// Exact sums of numbers of frames: the same in any order.
#pragma once
#include <array>
#include <cstdint>

#include "base/bytes.hpp"
#include "fit/spread.hpp"

namespace toliman::coadd {

__extension__ typedef __int128 Wide;

// Sum of integer weights times numbers, which are rounded to 2^-kBits.
class WeightedSum {
  public:
    static constexpr int kBits = 36;
    void add(int64_t weight, double number) noexcept {
        sum_ += static_cast<Wide>(weight) * static_cast<int64_t>(std::nearbyint(number * kOne));
    }
    long double over(int64_t weights) const noexcept {
        return static_cast<long double>(sum_) / kOne / static_cast<long double>(weights);
    }
    void save(ByteWriter &out) const;
    void load(ByteReader &in);

  private:
    static constexpr double kOne = 0x1p36;
    Wide sum_ = 0;
};

// Moments of the places of light, and the covariance that registration adds to them.
class Moments {
  public:
    // x, y: at most 2^4 px.
    void add(int64_t photons, double x, double y, double xx, double xy, double yy) noexcept;
    void clear() noexcept { *this = {}; }
    // Mean place [x, y], and the spread about it, of `photons` > 0 in all.
    void mean(int64_t photons, double *place) const noexcept;
    Spread spread(int64_t photons) const noexcept;
    double registered(size_t i, int64_t photons) const noexcept { // xx, xy, yy that was subtracted
        return static_cast<double>(noise_[i].over(photons));
    }
    void save(ByteWriter &out) const;
    void load(ByteReader &in);

  private:
    std::array<WeightedSum, fit::kSpreadTerms> sums_;
    std::array<WeightedSum, 3> noise_;
};

} // namespace toliman::coadd
