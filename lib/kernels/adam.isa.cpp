// Method: m <- m + (1 - beta1)(g - m), v <- v + (1 - beta2)(g^2 - v), w <- w - stride m/(sqrt(v unbias) + epsilon),
// where stride and unbias contain the bias corrections. Element-wise and without contraction: the same bits on every
// instruction set.
// Reference: Kingma and Ba (2015), "Adam: a method for stochastic optimization", ICLR.
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
