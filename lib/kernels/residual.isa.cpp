// Method: element-wise residuals, and inner products as 16 interleaved partial sums. 16 is fixed, independent of the
// vector width, so that every instruction set adds in the same order and gives the same bits. Compensated sums
// (kernels/project.hpp) are used where planes are prepared once. They are not used per frame, because the rounding
// here, below 5e-13, is far below the noise.
#include "kernels/residual.hpp"

#include <cstdint>

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// 1 for infinity and NaN, whose exponent bits are all set; 0 for a finite number.
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

double inner(const double *a, const double *b, size_t count) noexcept {
    constexpr size_t kParts = 16;
    double part[kParts] = {};
    for (size_t i = 0; i < count; i += kParts)
        for (size_t p = 0; p < kParts; p++)
            part[p] += a[i + p] * b[i + p];
    for (size_t half = kParts / 2; half > 0; half /= 2)
        for (size_t p = 0; p < half; p++)
            part[p] += part[p + half];
    return part[0];
}

void project_out(const double *basis, size_t planes, size_t count, double *vector) noexcept {
    for (size_t k = 0; k < planes; k++) {
        const double *unit = basis + k * count;
        const double component = inner(unit, vector, count);
        for (size_t i = 0; i < count; i++)
            vector[i] -= component * unit[i];
    }
}

} // namespace
} // namespace TOLIMAN_ISA

const ResidualKernels TOLIMAN_ISA_TABLE(residual) = {TOLIMAN_ISA::residual, TOLIMAN_ISA::scaled_residual,
                                                     TOLIMAN_ISA::project_out, TOLIMAN_ISA::inner};

} // namespace toliman::kernels
