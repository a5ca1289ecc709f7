#include "kernels/residual.hpp"

#include <cstdint>

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// 0 for a finite number: its exponent is below the largest.
inline uint64_t not_finite(double value) noexcept {
    uint64_t bits;
    __builtin_memcpy(&bits, &value, sizeof bits);
    return (bits & 0x7ff0000000000000u) == 0x7ff0000000000000u;
}

bool residual(const double *counts, const double *reference, const double *inverse_sigma, size_t count,
              double *out) noexcept {
    uint64_t bad = 0;
    for (size_t i = 0; i < count; i++) {
        bad |= not_finite(counts[i]);
        out[i] = (counts[i] - reference[i]) * inverse_sigma[i];
    }
    return bad == 0;
}

bool scaled_residual(const double *counts, const double *reference, const double *inverse_sigma, double scale,
                     size_t count, float *out) noexcept {
    uint64_t bad = 0;
    for (size_t i = 0; i < count; i++) {
        bad |= not_finite(counts[i]);
        out[i] = static_cast<float>(scale * ((counts[i] - reference[i]) * inverse_sigma[i]));
    }
    return bad == 0;
}

} // namespace
} // namespace TOLIMAN_ISA

const ResidualKernels TOLIMAN_ISA_TABLE(residual) = {TOLIMAN_ISA::residual, TOLIMAN_ISA::scaled_residual};

} // namespace toliman::kernels
