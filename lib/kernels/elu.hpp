// Exponential linear unit and what its backward pass takes, float32.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct EluKernels {
    // Given     values [count]
    // Returned  values [count]: x where x > 0, exp(x) - 1 elsewhere; NaN stays NaN
    // Notes     relative error below 2e-7 down to the smallest inputs, where exp(x) - 1 would lose them; the same bits
    //           on every instruction set with fused multiply-add.
    // Reference coefficients of Cephes expf (S. Moshier)
    void (*elu)(float *values, size_t count) noexcept;

    // Given     values [count] of elu, gradient [count] by them
    // Returned  gradient by its arguments: times 1 where the value is above 0, times value + 1 elsewhere
    void (*slope)(const float *values, size_t count, float *gradient) noexcept;

    // Given     image [count] of pixels of `channels` floats; channels a divisor of 64
    // Returned  sums [channels] with the image's sum over its pixels added; relative rounding below 2e-6 of the sum of
    //           absolute values
    void (*sum_pixels)(const float *image, size_t count, size_t channels, float *sums) noexcept;
};
TOLIMAN_ISA_DECLARE(EluKernels, elu)

} // namespace toliman::kernels
