// Whitened residuals of counts, as the network reads them.
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
};
TOLIMAN_ISA_DECLARE(ResidualKernels, residual)

} // namespace toliman::kernels
