// Method: element-wise residuals, and inner products as 16 interleaved partial sums. 16 is fixed, independent of the
// vector width, so that every instruction set adds in the same order and gives the same bits. Compensated sums
// (kernels/project.hpp) are used where planes are prepared once, and for the template's estimate. The projection of a
// frame needs none: its rounding, below 5e-13, is far below the noise.
#include "kernels/residual.hpp"

#include "kernels/finite.hpp"
#if defined(__FMA__)
#include <immintrin.h>
#endif

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

double inner_float(const float *a, const float *b, size_t count) noexcept {
    double part[8] = {};
    for (size_t i = 0; i < count; i += 8)
        for (size_t p = 0; p < 8; p++)
            part[p] += static_cast<double>(a[i + p]) * static_cast<double>(b[i + p]);
    return ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
}

// Largest magnitude and excess, in lanes.
template <class Real> class Largest {
  public:
    typedef Real Vector __attribute__((vector_size(64)));
    static constexpr size_t kWidth = 64 / sizeof(Real);

    Largest(Real most, Real excess) noexcept : most_(most - Vector{}), excess_(excess - Vector{}) {}
    void take(const Vector &value, const Vector &tail) noexcept {
        const Vector zero = {}, positive = value > zero ? value : zero, size = positive - (value > zero ? zero : value),
                     beyond = value * value - positive * tail;
        most_ = size > most_ ? size : most_;
        excess_ = beyond > excess_ ? beyond : excess_;
    }
    void get(Real *most, Real *excess) const noexcept {
        for (size_t lane = 0; lane < kWidth; lane++) {
            *most = most_[lane] > *most ? most_[lane] : *most;
            *excess = excess_[lane] > *excess ? excess_[lane] : *excess;
        }
    }
    static void load(const Real *from, Vector &to) noexcept { __builtin_memcpy(&to, from, sizeof to); }

  private:
    Vector most_, excess_;
};

void largest(const double *residual, const double *tail, size_t count, double *most, double *excess) noexcept {
    using Found = Largest<double>;
    Found found(*most, *excess);
    Found::Vector value, tails;
    size_t i = 0;
    for (; i + Found::kWidth <= count; i += Found::kWidth) {
        Found::load(residual + i, value);
        Found::load(tail + i, tails);
        found.take(value, tails);
    }
    for (; i < count; i++)
        found.take(residual[i] - Found::Vector{}, tail[i] - Found::Vector{});
    found.get(most, excess);
}

void largest_float(const float *residual, float component, const float *target, const float *tail, size_t count,
                   float *most, float *excess) noexcept {
    using Found = Largest<float>;
    Found found(*most, *excess);
    Found::Vector value, known, tails;
    for (size_t i = 0; i < count; i += Found::kWidth) {
        Found::load(residual + i, value);
        Found::load(target + i, known);
        Found::load(tail + i, tails);
        found.take(value - component * known, tails);
    }
    found.get(most, excess);
}

template <class Real> Real magnitude(const Real *residual, size_t count, Real most) noexcept {
    using Found = Largest<Real>;
    using Vector = typename Found::Vector;
    Vector low = Vector{} - most, high = most - Vector{};
    const auto take = [&](const Vector &value) {
        low = value < low ? value : low;
        high = value > high ? value : high;
    };
    Vector value;
    size_t i = 0;
    for (; i + Found::kWidth <= count; i += Found::kWidth) {
        Found::load(residual + i, value);
        take(value);
    }
    for (; i < count; i++)
        take(residual[i] - Vector{});
    for (size_t lane = 0; lane < Found::kWidth; lane++) {
        most = -low[lane] > most ? -low[lane] : most;
        most = high[lane] > most ? high[lane] : most;
    }
    return most;
}

template <size_t Planes>
inline void subtract(const double *basis, size_t stride, const double *component, size_t count,
                     double *vector) noexcept {
    for (size_t i = 0; i < count; i++) {
        double value = vector[i];
        for (size_t k = 0; k < Planes; k++)
            value -= component[k] * basis[k * stride + i];
        vector[i] = value;
    }
}

void project_out(const double *basis, size_t planes, size_t count, double *vector) noexcept {
    double component[kMaxPlanes];
    for (size_t k = 0; k < planes; k++)
        component[k] = inner(basis + k * count, vector, count);
    size_t k = 0;
    for (; k + 4 <= planes; k += 4)
        subtract<4>(basis + k * count, count, component + k, count, vector);
    for (; k < planes; k++)
        subtract<1>(basis + k * count, count, component + k, count, vector);
}

// A vector of doubles, and of as many floats.
#if defined(__AVX512F__)
constexpr size_t kLanes = 8, kPlanesAtOnce = 4, kFramesAtOnce = 4; // 16 sums in registers
#elif defined(__AVX__)
constexpr size_t kLanes = 4, kPlanesAtOnce = 2, kFramesAtOnce = 4;
#else
constexpr size_t kLanes = 2, kPlanesAtOnce = 2, kFramesAtOnce = 4;
#endif
typedef double Doubles __attribute__((vector_size(8 * kLanes)));
typedef float Floats __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));

// Intrinsics, because GCC 12 converts vectors half by half; with a full mask, because it warns of those without.
inline Doubles load(const float *from) noexcept {
#if defined(__AVX512F__)
    return _mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(from));
#elif defined(__AVX__)
    return _mm256_cvtps_pd(_mm_loadu_ps(from));
#else
    return __builtin_convertvector(*reinterpret_cast<const Floats *>(from), Doubles);
#endif
}
inline void store(float *to, Doubles value) noexcept {
#if defined(__AVX512F__)
    _mm256_storeu_ps(to, _mm512_maskz_cvtpd_ps(0xff, value));
#elif defined(__AVX__)
    _mm_storeu_ps(to, _mm256_cvtpd_ps(value));
#else
    *reinterpret_cast<Floats *>(to) = __builtin_convertvector(value, Floats);
#endif
}
inline Doubles splat(double value) noexcept {
    return value - Doubles{};
}

// sum + a b for a and b that were float32. Their product is exact, so that the result is the same with and without a
// fused operation.
inline Doubles add_product(Doubles sum, Doubles a, Doubles b) noexcept {
#if defined(__AVX512F__)
    return _mm512_fmadd_pd(a, b, sum);
#elif defined(__FMA__)
    return _mm256_fmadd_pd(a, b, sum);
#else
    return sum + a * b;
#endif
}

// Sums in progress of the components along all planes, for each frame.
constexpr size_t kVectors = kParts / kLanes;
struct Sums {
    Doubles part[kMaxPlanes][kVectors];
};
struct DoubleRow {
    Doubles at[kMaxColumns / kLanes];
};

// Adds the components of a row of Frames vectors along the Planes planes from k on. A plane's numbers are converted
// once for all frames.
template <size_t Planes, size_t Frames>
inline void add(const float *planes, size_t k, size_t cols, const DoubleRow *rows, Sums *sums) noexcept {
    for (size_t v = 0; v < kVectors; v++) {
        Doubles sum[Frames][Planes];
        for (size_t f = 0; f < Frames; f++)
            for (size_t i = 0; i < Planes; i++)
                sum[f][i] = sums[f].part[k + i][v];
        for (size_t c = v * kLanes; c < cols; c += kParts)
#pragma GCC unroll 8
            for (size_t i = 0; i < Planes; i++) {
                const Doubles plane = load(planes + (k + i) * cols + c);
#pragma GCC unroll 8
                for (size_t f = 0; f < Frames; f++)
                    sum[f][i] = add_product(sum[f][i], plane, rows[f].at[c / kLanes]);
            }
        for (size_t f = 0; f < Frames; f++)
            for (size_t i = 0; i < Planes; i++)
                sums[f].part[k + i][v] = sum[f][i];
    }
}

template <size_t Frames>
void add_components(const float *planes, size_t count, size_t cols, const DoubleRow *rows, Sums *sums) noexcept {
    size_t k = 0;
    for (; k + kPlanesAtOnce <= count; k += kPlanesAtOnce)
        add<kPlanesAtOnce, Frames>(planes, k, cols, rows, sums);
    for (; k < count; k++)
        add<1, Frames>(planes, k, cols, rows, sums);
}

bool components(const ProjectedRows &given, size_t frames, const double *const *counts, size_t counts_stride,
                float *const *vectors, float *const *components) noexcept {
    const ProjectedRows rows = given;
    const size_t cols = rows.cols;
    Sums sums[kMaxTogether] = {};
    DoubleRow row[kMaxTogether];
    bool finite = true;
    for (size_t r = 0; r < rows.rows; r++) {
        const size_t at = r * cols;
        const float *const planes = rows.basis + at * rows.planes;
        for (size_t f = 0; f < frames; f++) {
            finite &= scaled_residual(counts[f] + r * counts_stride, rows.reference + at, rows.inverse_sigma + at, 1,
                                      cols, vectors[f] + at);
            for (size_t c = 0; c < cols; c += kLanes)
                row[f].at[c / kLanes] = load(vectors[f] + at + c);
        }
        size_t f = 0;
        for (; f + kFramesAtOnce <= frames; f += kFramesAtOnce)
            add_components<kFramesAtOnce>(planes, rows.planes, cols, row + f, sums + f);
        for (; f < frames; f++)
            add_components<1>(planes, rows.planes, cols, row + f, sums + f);
    }
    for (size_t f = 0; f < frames; f++)
        for (size_t k = 0; k < rows.planes; k++) {
            double part[kParts];
            __builtin_memcpy(part, sums[f].part[k], sizeof part);
            components[f][k] = static_cast<float>(total(part));
        }
    return finite;
}

// Subtracts the components of a row of Frames vectors.
template <size_t Frames>
void project(const ProjectedRows &rows, const float *planes, const float *const *components, float *const *row,
             float *const *out) noexcept {
    const size_t count = rows.planes, cols = rows.cols;
    double minus[kMaxPlanes][Frames];
    for (size_t k = 0; k < count; k++)
        for (size_t f = 0; f < Frames; f++)
            minus[k][f] = -static_cast<double>(components[f][k]);
    for (size_t c = 0; c < cols; c += kLanes) {
        Doubles value[Frames];
#pragma GCC unroll 8
        for (size_t f = 0; f < Frames; f++)
            value[f] = load(row[f] + c);
        for (size_t k = 0; k < count; k++) {
            const Doubles plane = load(planes + k * cols + c);
#pragma GCC unroll 8
            for (size_t f = 0; f < Frames; f++)
                value[f] = add_product(value[f], plane, splat(minus[k][f]));
        }
#pragma GCC unroll 8
        for (size_t f = 0; f < Frames; f++) {
            store(row[f] + c, value[f]);
            store(out[f] + c, rows.scale * value[f]);
        }
    }
}

void project_row(const ProjectedRows &given, size_t frames, const float *const *components, size_t r,
                 float *const *vectors, float *const *out) noexcept {
    const ProjectedRows rows = given;
    const size_t at = r * rows.cols;
    float *row[kMaxTogether];
    for (size_t f = 0; f < frames; f++)
        row[f] = vectors[f] + at;
    const float *const planes = rows.basis + at * rows.planes;
    size_t f = 0;
    for (; f + kFramesAtOnce <= frames; f += kFramesAtOnce)
        project<kFramesAtOnce>(rows, planes, components + f, row + f, out + f);
    for (; f < frames; f++)
        project<1>(rows, planes, components + f, row + f, out + f);
}

} // namespace
} // namespace TOLIMAN_ISA

const ResidualKernels TOLIMAN_ISA_TABLE(residual) = {
    TOLIMAN_ISA::residual,    TOLIMAN_ISA::scaled_residual, TOLIMAN_ISA::project_out,  TOLIMAN_ISA::components,
    TOLIMAN_ISA::project_row, TOLIMAN_ISA::inner,           TOLIMAN_ISA::inner_float,  TOLIMAN_ISA::largest,
    TOLIMAN_ISA::magnitude,   TOLIMAN_ISA::magnitude,       TOLIMAN_ISA::largest_float};

} // namespace toliman::kernels
