// Weights of Lagrange's interpolation polynomial at nodes at any distances.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace toliman::sky {

// Differences of times are exact up to 2^53 ns, 104 days.
template <size_t kCount> class LagrangeNodes {
  public:
    using Weights = std::array<double, kCount>;

    explicit LagrangeNodes(const int64_t *times) noexcept {
        for (size_t i = 0; i < kCount; i++)
            times_[i] = times[i];
        for (size_t i = 0; i < kCount; i++)
            below_[i] = products(times_[i])[i];
    }

    // weight[i] = product of (at - time[j])/(time[i] - time[j]) over all j other than i; exactly 1 and 0 at a node.
    Weights at(int64_t at) const noexcept {
        Weights weights = products(at);
        for (size_t i = 0; i < kCount; i++)
            weights[i] /= below_[i];
        return weights;
    }

  private:
    // Products of (at - time[j]) over all j other than i.
    Weights products(int64_t at) const noexcept {
        Weights out;
        double product = 1;
        for (size_t i = 0; i < kCount; i++) {
            out[i] = product;
            product *= static_cast<double>(at - times_[i]);
        }
        product = 1;
        for (size_t i = kCount; i-- > 0;) {
            out[i] *= product;
            product *= static_cast<double>(at - times_[i]);
        }
        return out;
    }

    std::array<int64_t, kCount> times_;
    Weights below_;
};

} // namespace toliman::sky
