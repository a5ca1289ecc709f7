// Method: each sample adds its strength times a kernel of 5 to 15 cells to a periodic grid (gridding). The kernel is a
// polynomial per cell, evaluated by Horner's scheme for all cells at once in vectors of 8, 12 or 16 lanes, without the
// Bessel functions of its definition. Positions and phases are products of a time and a frequency, reduced modulo 1
// with their rounding errors carried along: a time span of many periods costs no accuracy. Phases are computed for 64
// samples in one vector loop, the grid is updated sample by sample, because neighbouring samples overlap.
//
// The choice of kernel and grid, and the error bound, are in period/batch/nufft.cpp.
// Reference: Barnett, Magland and af Klinteberg (2019), SIAM J. Sci. Comput. 41, C479.
#include "kernels/spread.hpp"

#include <cstdint>

#include "kernels/cis.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kChunk = 64; // samples per vector loop over phases
constexpr size_t kAtOnce = 4; // samples whose kernels are evaluated together

struct Chunk {
    alignas(64) double first[kChunk], argument[kChunk] = {}; // first cell; argument of the polynomials
    alignas(64) double strengths[4][kChunk];
};

void find_phases(const SpreadSamples &samples, const SpreadPhases &phases, double half_width, size_t pairs,
                 size_t begin, size_t n, Chunk &chunk) noexcept {
    for (size_t j = 0; j < n; j++) {
        const double t = samples.t_high[begin + j], t_low = samples.t_low[begin + j];
        // The fractional part of df t and the position in cells, both as unevaluated sums: their errors do not grow
        // with the number of periods or cells.
        const double cycles = phases.df * t, error = product_error(phases.df, t, cycles) + phases.df * t_low;
        const double part = reduce_cycles(cycles), sum = part + error, sum_low = (part - sum) + error;
        const double phase = reduce_cycles(sum), cells = phases.cells * phase, nearest = nearest_whole(cells);
        const double off = (cells - nearest) + (product_error(phases.cells, phase, cells) + phases.cells * sum_low);
        const double first = nearest - half_width;
        chunk.first[j] = first < 0 ? first + phases.cells : first;
        chunk.argument[j] = -2 * off;
    }
    for (size_t j = 0; j < n; j++) {
        double c, s;
        cis_product(phases.f_high, phases.f_low, samples.t_high[begin + j], samples.t_low[begin + j], c, s);
        chunk.strengths[0][j] = c;
        chunk.strengths[1][j] = s;
    }
    for (size_t p = pairs; p-- > 0;) // the first pair last: until then it holds cosine and sine
        for (size_t j = 0; j < n; j++) {
            const double weight = samples.weights[p][begin + j];
            chunk.strengths[2 * p + 1][j] = weight * chunk.strengths[1][j];
            chunk.strengths[2 * p][j] = weight * chunk.strengths[0][j];
        }
}

#if defined(__AVX512F__)
constexpr size_t kWidest = 8; // numbers per vector
#else
constexpr size_t kWidest = 4;
#endif

// Kernels of several samples at once: Horner's scheme for one sample would wait for each of its own steps. All sums
// stay in registers.
template <size_t lanes>
inline void kernels_of(const double *arguments, const SpreadShape &shape, double (*kernels)[lanes]) noexcept {
    constexpr size_t width = lanes % kWidest == 0 ? kWidest : 4, vectors = lanes / width;
    typedef double Vector __attribute__((vector_size(8 * width), aligned(8), may_alias));
    const double *coefficients = shape.coefficients + shape.degree * lanes;
    Vector sum[kAtOnce][vectors];
    for (size_t v = 0; v < vectors; v++)
        for (size_t j = 0; j < kAtOnce; j++)
            sum[j][v] = *reinterpret_cast<const Vector *>(coefficients + v * width);
    for (size_t d = shape.degree; d-- > 0;) {
        coefficients -= lanes;
#pragma GCC unroll 4
        for (size_t v = 0; v < vectors; v++) {
            const Vector coefficient = *reinterpret_cast<const Vector *>(coefficients + v * width);
#pragma GCC unroll 4
            for (size_t j = 0; j < kAtOnce; j++)
                sum[j][v] = sum[j][v] * arguments[j] + coefficient;
        }
    }
    for (size_t j = 0; j < kAtOnce; j++)
        for (size_t v = 0; v < vectors; v++)
            *reinterpret_cast<Vector *>(&kernels[j][v * width]) = sum[j][v];
}

template <size_t lanes, size_t pairs>
void spread_chunk(const Chunk &chunk, size_t n, const SpreadShape &shape, double *const *grids) noexcept {
    alignas(64) double kernels[kAtOnce][lanes];
    for (size_t begin = 0; begin < n; begin += kAtOnce) {
        kernels_of<lanes>(chunk.argument + begin, shape, kernels);
        for (size_t j = 0; j < kAtOnce && begin + j < n; j++) {
            const auto first = static_cast<size_t>(static_cast<int64_t>(chunk.first[begin + j]));
            for (size_t g = 0; g < 2 * pairs; g++) {
                const double strength = chunk.strengths[g][begin + j];
                double *out = grids[g] + first;
                for (size_t i = 0; i < lanes; i += 4) { // wider vectors would straddle more cache lines
                    typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
                    *reinterpret_cast<Four *>(out + i) += strength * *reinterpret_cast<const Four *>(&kernels[j][i]);
                }
            }
        }
    }
}

template <size_t lanes>
void spread_lanes(const Chunk &chunk, size_t n, const SpreadShape &shape, size_t pairs, double *const *grids) noexcept {
    if (pairs == 1)
        spread_chunk<lanes, 1>(chunk, n, shape, grids);
    else
        spread_chunk<lanes, 2>(chunk, n, shape, grids);
}

void spread(const SpreadSamples &samples, const SpreadShape &shape, const SpreadPhases &phases, size_t pairs,
            double *const *grids) noexcept {
    Chunk chunk;
    const size_t below = shape.width / 2;
    const double half_width = static_cast<double>(below);
    for (size_t begin = 0; begin < samples.n; begin += kChunk) {
        const size_t n = samples.n - begin < kChunk ? samples.n - begin : kChunk;
        find_phases(samples, phases, half_width, pairs, begin, n, chunk);
        if (shape.lanes == 8)
            spread_lanes<8>(chunk, n, shape, pairs, grids);
        else if (shape.lanes == 12)
            spread_lanes<12>(chunk, n, shape, pairs, grids);
        else
            spread_lanes<16>(chunk, n, shape, pairs, grids);
    }
}

} // namespace
} // namespace TOLIMAN_ISA

extern const SpreadKernels TOLIMAN_ISA_TABLE(spread) = {TOLIMAN_ISA::spread};

} // namespace toliman::kernels
