#include "kernels/adam.hpp"

#include <cmath>

namespace toliman::kernels {

void adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
          float *weights) noexcept {
    constexpr double kBeta1 = 0.9, kBeta2 = 0.999;
    constexpr float kEpsilon = 1e-8f;
    const double age = static_cast<double>(step);
    const float mean_share = static_cast<float>(1 - kBeta1), square_share = static_cast<float>(1 - kBeta2);
    const float stride = static_cast<float>(rate / (1 - std::pow(kBeta1, age)));
    const float unbias = static_cast<float>(1 / (1 - std::pow(kBeta2, age)));
    for (size_t i = 0; i < count; i++) {
        mean[i] += mean_share * (gradient[i] - mean[i]);
        square[i] += square_share * (gradient[i] * gradient[i] - square[i]);
        weights[i] -= stride * mean[i] / (std::sqrt(square[i] * unbias) + kEpsilon);
    }
}

} // namespace toliman::kernels
