#include "kernels/adam.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

void update(float stride, float unbias, const float *gradient, size_t count, float *mean, float *square,
            float *weights) noexcept {
    constexpr float kMeanShare = static_cast<float>(1 - 0.9), kSquareShare = static_cast<float>(1 - 0.999);
    constexpr float kEpsilon = 1e-8f;
    for (size_t i = 0; i < count; i++) {
        mean[i] += kMeanShare * (gradient[i] - mean[i]);
        square[i] += kSquareShare * (gradient[i] * gradient[i] - square[i]);
        weights[i] -= stride * mean[i] / (__builtin_sqrtf(square[i] * unbias) + kEpsilon);
    }
}

} // namespace
} // namespace TOLIMAN_ISA

const AdamKernels TOLIMAN_ISA_TABLE(adam) = {TOLIMAN_ISA::update};

} // namespace toliman::kernels
