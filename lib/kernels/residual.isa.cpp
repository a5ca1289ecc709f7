// Method: element-wise residuals, and inner products as 16 interleaved partial sums. 16 is fixed, independent of the
// vector width, so that every instruction set adds in the same order and gives the same bits. Compensated sums
// (kernels/project.hpp) are used where planes are prepared once, and for the template's estimate. The projection of a
// frame needs none: its rounding, below 5e-13, is far below the noise.
#include "kernels/residual.hpp"

#include "kernels/finite.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kBlock = 32, kAhead = 512; // elements per block; elements ahead of it that are prefetched
// The processor's own prefetch stops at the end of a page.
inline void prefetch(const double *a, const double *b, const double *c, size_t first, size_t end) noexcept {
    for (size_t i = first + kAhead; i < end + kAhead; i += 8) { // a cache line
        __builtin_prefetch(a + i);
        __builtin_prefetch(b + i);
        __builtin_prefetch(c + i);
    }
}

bool residual(const double *counts, const double *reference, const double *inverse_sigma, size_t count,
              double *out) noexcept {
    uint64_t bad = 0;
    for (size_t first = 0; first < count; first += kBlock) {
        const size_t end = count - first < kBlock ? count : first + kBlock;
        prefetch(counts, reference, inverse_sigma, first, end);
        for (size_t i = first; i < end; i++) {
            bad |= not_finite(counts[i]);
            out[i] = (counts[i] - reference[i]) * inverse_sigma[i];
        }
    }
    return bad == 0;
}

bool scaled_residual(const double *counts, const double *reference, const double *inverse_sigma, double scale,
                     size_t count, float *out) noexcept {
    uint64_t bad = 0;
    for (size_t first = 0; first < count; first += kBlock) {
        const size_t end = count - first < kBlock ? count : first + kBlock;
        prefetch(counts, reference, inverse_sigma, first, end);
        for (size_t i = first; i < end; i++) {
            bad |= not_finite(counts[i]);
            out[i] = static_cast<float>(scale * ((counts[i] - reference[i]) * inverse_sigma[i]));
        }
    }
    return bad == 0;
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

// Adds the components of a vector along Planes planes, `stride` apart, to sums in progress.
template <size_t Planes, class Plane>
inline void add(const Plane *basis, size_t stride, const double *vector, size_t count,
                double (*parts)[kParts]) noexcept {
    double part[Planes][kParts];
    for (size_t k = 0; k < Planes; k++)
        for (size_t p = 0; p < kParts; p++)
            part[k][p] = parts[k][p];
    for (size_t i = 0; i < count; i += kParts)
        for (size_t k = 0; k < Planes; k++)
            for (size_t p = 0; p < kParts; p++)
                part[k][p] += static_cast<double>(basis[k * stride + i + p]) * vector[i + p];
    for (size_t k = 0; k < Planes; k++)
        for (size_t p = 0; p < kParts; p++)
            parts[k][p] = part[k][p];
}

template <size_t Planes, class Plane>
inline void subtract(const Plane *basis, size_t stride, const double *component, size_t count,
                     double *vector) noexcept {
    for (size_t i = 0; i < count; i++) {
        double value = vector[i];
        for (size_t k = 0; k < Planes; k++)
            value -= component[k] * static_cast<double>(basis[k * stride + i]);
        vector[i] = value;
    }
}

template <class Plane>
void add_components(const Plane *basis, size_t stride, size_t planes, const double *vector, size_t count,
                    double (*parts)[kParts]) noexcept {
    size_t k = 0;
    for (; k + 4 <= planes; k += 4)
        add<4>(basis + k * stride, stride, vector, count, parts + k);
    for (; k < planes; k++)
        add<1>(basis + k * stride, stride, vector, count, parts + k);
}

template <class Plane>
void subtract_components(const Plane *basis, size_t stride, size_t planes, const double *component, size_t count,
                         double *vector) noexcept {
    size_t k = 0;
    for (; k + 4 <= planes; k += 4)
        subtract<4>(basis + k * stride, stride, component + k, count, vector);
    for (; k < planes; k++)
        subtract<1>(basis + k * stride, stride, component + k, count, vector);
}

void project_out(const double *basis, size_t planes, size_t count, double *vector) noexcept {
    double parts[kMaxPlanes][kParts] = {}, component[kMaxPlanes];
    add_components(basis, count, planes, vector, count, parts);
    for (size_t k = 0; k < planes; k++)
        component[k] = total(parts[k]);
    subtract_components(basis, count, planes, component, count, vector);
}

bool project_rows(const ProjectedRows &given, const double *counts, size_t counts_stride, double *vector, float *out,
                  size_t out_stride) noexcept {
    const ProjectedRows rows = given;
    const size_t cols = rows.cols, stride = rows.rows * cols;
    double parts[kMaxPlanes][kParts] = {}, component[kMaxPlanes];
    bool finite = true;
    for (size_t r = 0; r < rows.rows; r++) {
        const size_t at = r * cols;
        finite &= residual(counts + r * counts_stride, rows.reference + at, rows.inverse_sigma + at, cols, vector + at);
        add_components(rows.basis + at, stride, rows.planes, vector + at, cols, parts);
    }
    for (size_t k = 0; k < rows.planes; k++)
        component[k] = total(parts[k]);
    for (size_t r = 0; r < rows.rows; r++) {
        double *row = vector + r * cols;
        subtract_components(rows.basis + r * cols, stride, rows.planes, component, cols, row);
        for (size_t c = 0; c < cols; c++)
            out[r * out_stride + c] = static_cast<float>(rows.scale * row[c]);
    }
    return finite;
}

} // namespace
} // namespace TOLIMAN_ISA

const ResidualKernels TOLIMAN_ISA_TABLE(residual) = {TOLIMAN_ISA::residual, TOLIMAN_ISA::scaled_residual,
                                                     TOLIMAN_ISA::project_out, TOLIMAN_ISA::project_rows,
                                                     TOLIMAN_ISA::inner};

} // namespace toliman::kernels
