// Exponential linear unit (ELU, alpha = 1) with its derivative, and sums of gradients over pixels. float32.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct EluKernels {
    // Given     values [count]
    // Returned  values [count]: x where x > 0, exp(x) - 1 elsewhere; NaN stays NaN
    // Notes     Relative error below 2e-7 for inputs of any size, small ones included. The same bits on every
    //           instruction set with fused multiply-add.
    // Reference Clevert, Unterthiner and Hochreiter (2016), ICLR; coefficients of Cephes expf (S. Moshier)
    void (*elu)(float *values, size_t count) noexcept;

    // Given     values [count] returned by elu; gradient [count] with respect to them
    // Returned  gradient with respect to elu's arguments: times 1 for values above 0, times value + 1 for others
    void (*slope)(const float *values, size_t count, float *gradient) noexcept;

    // Given     image [count], pixels of `channels` floats; channels a divisor of 64
    // Returned  sums [channels], increased by the sums over pixels
    // Notes     error below 2e-6 of the sum of absolute values
    void (*sum_pixels)(const float *image, size_t count, size_t channels, float *sums) noexcept;
};
TOLIMAN_ISA_DECLARE(EluKernels, elu)

} // namespace toliman::kernels
