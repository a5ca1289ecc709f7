// One step of the Adam optimiser, float32.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Given     step, counted from 1; rate > 0; gradient, weights [count]; mean, square [count], the running moments, zero
//           before step 1
// Returned  weights, mean, square after the step
// Notes     The same bits on every instruction set.
// Reference Kingma and Ba (2015), ICLR, algorithm 1; beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8
void adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
          float *weights) noexcept;

struct AdamKernels {
    // stride: rate/(1 - beta1^step); unbias: 1/(1 - beta2^step), the bias corrections of the two moments
    void (*update)(float stride, float unbias, const float *gradient, size_t count, float *mean, float *square,
                   float *weights) noexcept;
};
TOLIMAN_ISA_DECLARE(AdamKernels, adam)

} // namespace toliman::kernels
