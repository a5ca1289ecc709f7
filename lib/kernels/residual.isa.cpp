// Method: element-wise residuals, and inner products as 16 interleaved partial sums. 16 is fixed, independent of the
// vector width, so that every instruction set adds in the same order and gives the same bits. Compensated sums
// (kernels/project.hpp) are used where planes are prepared once. They are not used per frame, because the rounding
// here, below 5e-13, is far below the noise.
#include "kernels/residual.hpp"

#include "kernels/finite.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kBlock = 32, kAhead = 512; // elements per block; elements ahead of it that are prefetched
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
    for (size_t first = 0; first < count; first += kBlock) { // the processor's own prefetch stops at the end of a page
        const size_t end = count - first < kBlock ? count : first + kBlock;
        for (size_t i = first; i < end; i += 8) {
            __builtin_prefetch(counts + i + kAhead);
            __builtin_prefetch(reference + i + kAhead);
            __builtin_prefetch(inverse_sigma + i + kAhead);
        }
        for (size_t i = first; i < end; i++) {
            bad |= not_finite(counts[i]);
            out[i] = static_cast<float>(scale * ((counts[i] - reference[i]) * inverse_sigma[i]));
        }
    }
    return bad == 0;
}

void round(const double *vector, double scale, size_t count, float *rounded) noexcept {
    for (size_t i = 0; i < count; i++)
        rounded[i] = static_cast<float>(scale * vector[i]);
}

constexpr size_t kParts = 16;

inline double total(double *part) noexcept {
    for (size_t half = kParts / 2; half > 0; half /= 2)
        for (size_t p = 0; p < half; p++)
            part[p] += part[p + half];
    return part[0];
}

double inner(const double *a, const double *b, size_t count) noexcept {
    double part[kParts] = {};
    for (size_t i = 0; i < count; i += kParts)
        for (size_t p = 0; p < kParts; p++)
            part[p] += a[i + p] * b[i + p];
    return total(part);
}

// Components of the vector along Planes planes, in one pass.
template <size_t Planes, class Plane>
inline void components(const Plane *basis, size_t count, const double *vector, double *component) noexcept {
    double part[Planes][kParts] = {};
    for (size_t i = 0; i < count; i += kParts)
        for (size_t k = 0; k < Planes; k++)
            for (size_t p = 0; p < kParts; p++)
                part[k][p] += static_cast<double>(basis[k * count + i + p]) * vector[i + p];
    for (size_t k = 0; k < Planes; k++)
        component[k] = total(part[k]);
}

template <size_t Planes, class Plane>
inline void subtract(const Plane *basis, size_t count, const double *component, double *vector) noexcept {
    for (size_t i = 0; i < count; i++) {
        double value = vector[i];
        for (size_t k = 0; k < Planes; k++)
            value -= component[k] * static_cast<double>(basis[k * count + i]);
        vector[i] = value;
    }
}

template <class Plane> void project_out(const Plane *basis, size_t planes, size_t count, double *vector) noexcept {
    double component[kMaxPlanes];
    size_t k = 0;
    for (; k + 4 <= planes; k += 4)
        components<4>(basis + k * count, count, vector, component + k);
    for (; k < planes; k++)
        components<1>(basis + k * count, count, vector, component + k);
    for (k = 0; k + 4 <= planes; k += 4)
        subtract<4>(basis + k * count, count, component + k, vector);
    for (; k < planes; k++)
        subtract<1>(basis + k * count, count, component + k, vector);
}

} // namespace
} // namespace TOLIMAN_ISA

const ResidualKernels TOLIMAN_ISA_TABLE(residual) = {
    TOLIMAN_ISA::residual,           TOLIMAN_ISA::scaled_residual, TOLIMAN_ISA::project_out<double>,
    TOLIMAN_ISA::project_out<float>, TOLIMAN_ISA::round,           TOLIMAN_ISA::inner};

} // namespace toliman::kernels
