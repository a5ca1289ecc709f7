// Whitened and projected residuals of counts, as the network reads them.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct ResidualKernels {
    // Given     counts, reference, inverse_sigma [count]
    // Returned  residual [count] = (counts - reference) inverse_sigma; whether all counts are finite
    bool (*residual)(const double *counts, const double *reference, const double *inverse_sigma, size_t count,
                     double *residual) noexcept;

    // The same times scale, rounded to float32 last: the same bits as residual, scaled and rounded.
    bool (*scaled_residual)(const double *counts, const double *reference, const double *inverse_sigma, double scale,
                            size_t count, float *residual) noexcept;

    // Given     units [planes][count], orthonormal; vector [count], a multiple of 16
    // Returned  vector less its components along them, one after the other
    // Notes     plain sums in 16 parts: off by count/16 roundings of the sum of the absolute products at most, 5e-13 of
    //           it for a frame. kernels/project.hpp has the compensated form. The same bits on every instruction set.
    void (*project_out)(const double *units, size_t planes, size_t count, double *vector) noexcept;

    // Given     a, b [count], a multiple of 16
    // Returned  sum a_i b_i, by the same plain sums in 16 parts
    double (*inner)(const double *a, const double *b, size_t count) noexcept;
};
TOLIMAN_ISA_DECLARE(ResidualKernels, residual)

} // namespace toliman::kernels
