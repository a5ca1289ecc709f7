// Exponential linear unit, float32.
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
};
TOLIMAN_ISA_DECLARE(EluKernels, elu)

} // namespace toliman::kernels
