// Power from sums, defined for every input.
#pragma once
#include "period/stream.hpp"

namespace toliman::period {

// What one query needs of the totals, computed once.
class PowerQuery {
  public:
    explicit PowerQuery(const Stream &stream) noexcept;
    // Power at frequency k of the grid, in [0, 1], never NaN.
    double at(int64_t k) const noexcept;
    // Samples enough and not all equal: a peak means something.
    bool meaningful() const noexcept;

  private:
    const Stream &stream_;
    long double weight_, mean_, spread_;
    long double noise_; // error of a sum over W: an eigenvalue below it is nothing
};

} // namespace toliman::period
