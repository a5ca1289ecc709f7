// One step of the Adam optimiser, float32.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Given     gradient, weights [count]; mean, square [count], the running moments, zero before step 1; rate > 0
// Returned  weights, mean, square of after step number `step`
// Notes     the same bits on every instruction set.
// Reference Kingma and Ba (2015), beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8
void adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
          float *weights) noexcept;

struct AdamKernels {
    // stride: the rate over 1 - beta1^step; unbias: 1/(1 - beta2^step)
    void (*update)(float stride, float unbias, const float *gradient, size_t count, float *mean, float *square,
                   float *weights) noexcept;
};
TOLIMAN_ISA_DECLARE(AdamKernels, adam)

} // namespace toliman::kernels
