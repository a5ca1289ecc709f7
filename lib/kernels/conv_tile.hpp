// Inner loops of all convolutions, for files compiled once per instruction set; everything is in that set's namespace.
//
// Method: a convolution is a matrix product (runs of input floats) x (weights) -> (pixels x channels). The left matrix
// is never formed (no im2col), because each of its rows is a run of contiguous floats of the image. The accumulators of
// a tile of pixels and output channels stay in registers; a weight vector is loaded once per tile, an input float is
// broadcast. Tile sizes are chosen for 32 registers with AVX-512 and 16 otherwise. Vectors run over channels.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Vector types; loads and stores need no alignment. A vector that may be anywhere is read and written through a pointer
// here only: clang takes references to it, and to arrays of it, as aligned to its size.
// NOLINTBEGIN(misc-definitions-in-headers): each file that includes this has it in a namespace of its own
#define TOLIMAN_LANES(N)                                                                                               \
    struct Lanes##N {                                                                                                  \
        typedef float Vector __attribute__((vector_size(4 * (N))));                                                    \
        typedef int32_t Mask __attribute__((vector_size(4 * (N))));                                                    \
        typedef float Anywhere __attribute__((vector_size(4 * (N)), aligned(4), may_alias));                           \
        typedef int32_t MaskAnywhere __attribute__((vector_size(4 * (N)), aligned(4), may_alias));                     \
        [[maybe_unused]] static constexpr size_t count = N;                                                            \
        static Vector load(const float *from) noexcept { return *reinterpret_cast<const Anywhere *>(from); }           \
        static Mask load(const int32_t *from) noexcept { return *reinterpret_cast<const MaskAnywhere *>(from); }       \
        static void store(float *to, Vector value) noexcept { *reinterpret_cast<Anywhere *>(to) = value; }             \
        static void store(int32_t *to, Mask value) noexcept { *reinterpret_cast<MaskAnywhere *>(to) = value; }         \
    }
TOLIMAN_LANES(4);
#if defined(__AVX512F__)
TOLIMAN_LANES(8);
TOLIMAN_LANES(16);
using Wide = Lanes16;
using Eight = Lanes8;         // at most eight lanes, for eight channels
constexpr size_t kPixels = 8; // per tile of two vectors: 16 accumulators, two weights and an input fit 32 registers
constexpr size_t kSinglePixels = 16; // per tile of one vector, for a constant step
constexpr size_t kRuns = 4;          // inputs per tile of three rows and two vectors: 24 accumulators
#elif defined(__AVX__)
TOLIMAN_LANES(8);
using Wide = Lanes8;
using Eight = Wide;
constexpr size_t kPixels = 4, kSinglePixels = 8, kRuns = 2;
#else
using Wide = Lanes4;
using Eight = Wide;
constexpr size_t kPixels = 4, kSinglePixels = 8, kRuns = 2;
#endif
#undef TOLIMAN_LANES

constexpr size_t kMaxRows = 4;

// A row of output pixels. Each is the sum over `rows` runs of `run` contiguous input floats times the weights.
struct Row {
    const float *in[kMaxRows]; // start of the run of pixel 0, per input row
    size_t in_step;            // floats between the runs of adjacent output pixels
    size_t rows, run;
    const float *weights; // [rows][run][outputs]
    const float *bias;    // [outputs], or NULL for zeros
    float *out;
    size_t out_step, outputs, pixels;
};

// One tile: M vectors of output channels from `first` on, for P adjacent pixels. RUN and STEP: row.run and row.in_step
// if known at compile time, or 0; the addresses of 16 pixels need a register each if STEP is not known. Inlined,
// because the sums are short compared with the cost of a call.
template <class Lanes, size_t P, size_t M, size_t RUN, size_t STEP>
inline __attribute__((always_inline)) void tile(const Row &row, size_t pixel, size_t first) noexcept {
    typename Lanes::Vector sum[P][M] = {};
    if (row.bias != nullptr)
        for (size_t p = 0; p < P; p++)
            for (size_t m = 0; m < M; m++)
                sum[p][m] = Lanes::load(row.bias + first + m * Lanes::count);
    const size_t run = RUN != 0 ? RUN : row.run, in_step = STEP != 0 ? STEP : row.in_step, outputs = row.outputs;
    const float *weights = row.weights + first;
    for (size_t r = 0; r < row.rows; r++) {
        const float *in = row.in[r] + pixel * in_step;
#pragma GCC unroll 4
        for (size_t j = 0; j < run; j++, in++, weights += outputs) {
            typename Lanes::Vector weight[M];
#pragma GCC unroll 16
            for (size_t m = 0; m < M; m++)
                weight[m] = Lanes::load(weights + m * Lanes::count);
#pragma GCC unroll 16
            for (size_t p = 0; p < P; p++)
#pragma GCC unroll 16
                for (size_t m = 0; m < M; m++)
                    sum[p][m] += weight[m] * in[p * in_step];
        }
    }
    float *out = row.out + pixel * row.out_step + first;
    for (size_t p = 0; p < P; p++)
        for (size_t m = 0; m < M; m++)
            Lanes::store(out + p * row.out_step + m * Lanes::count, sum[p][m]);
}

// All pixels of a row; those beyond the last whole tile one by one. The order of each sum is the same in both cases.
template <class Lanes, size_t P, size_t M, size_t RUN, size_t STEP> void tiles(const Row &given) noexcept {
    const Row row = given; // a local copy cannot alias the output, so that its members stay in registers
    const size_t whole = row.pixels / P * P;
    for (size_t first = 0; first < row.outputs; first += M * Lanes::count) {
        for (size_t pixel = 0; pixel < whole; pixel += P)
            tile<Lanes, P, M, RUN, STEP>(row, pixel, first);
        for (size_t pixel = whole; pixel < row.pixels; pixel++)
            tile<Lanes, 1, M, RUN, STEP>(row, pixel, first);
    }
}

// Computes a row of output pixels. outputs: a multiple of 8.
template <size_t RUN = 0, size_t STEP = 0> void convolve(const Row &row) noexcept {
    constexpr size_t kSingle = STEP != 0 ? kSinglePixels : 8;
    if constexpr (Wide::count > 8)
        if (row.outputs % Wide::count != 0)
            return tiles<Eight, 8, 1, RUN, STEP>(row);
    if constexpr (2 * Wide::count > 8)
        if (row.outputs % (2 * Wide::count) != 0)
            return tiles<Wide, kSingle, 1, RUN, STEP>(row);
    tiles<Wide, kPixels, 2, RUN, STEP>(row);
}

// Contribution of a row of pixels to the gradient of a kernel of three rows: the sum over pixels of the outer product
// of the input runs and the output channels.
struct Correlation {
    const float *in[3];
    size_t in_step, run;
    const float *out;
    size_t outputs, pixels;
    float *gradient; // [3][run][outputs]
};

// One tile of the gradient: J input floats from j on and M vectors of channels from k on, for three rows.
template <class Lanes, size_t J, size_t M> void outer(const Correlation &c, size_t j, size_t k) noexcept {
    float *gradient = c.gradient + j * c.outputs + k;
    const size_t next_row = c.run * c.outputs;
    typename Lanes::Vector sum[3][J][M];
    for (size_t r = 0; r < 3; r++)
        for (size_t i = 0; i < J; i++)
            for (size_t m = 0; m < M; m++)
                sum[r][i][m] = Lanes::load(gradient + r * next_row + i * c.outputs + m * Lanes::count);
    const float *in[3] = {c.in[0] + j, c.in[1] + j, c.in[2] + j}, *out = c.out + k;
    for (size_t x = 0; x < c.pixels; x++, out += c.outputs) {
        typename Lanes::Vector value[M];
#pragma GCC unroll 16
        for (size_t m = 0; m < M; m++)
            value[m] = Lanes::load(out + m * Lanes::count);
#pragma GCC unroll 3
        for (size_t r = 0; r < 3; r++) {
#pragma GCC unroll 16
            for (size_t i = 0; i < J; i++)
#pragma GCC unroll 16
                for (size_t m = 0; m < M; m++)
                    sum[r][i][m] += value[m] * in[r][i];
            in[r] += c.in_step;
        }
    }
    for (size_t r = 0; r < 3; r++)
        for (size_t i = 0; i < J; i++)
            for (size_t m = 0; m < M; m++)
                Lanes::store(gradient + r * next_row + i * c.outputs + m * Lanes::count, sum[r][i][m]);
}

template <class Lanes, size_t J, size_t M> void outers(const Correlation &c) noexcept {
    for (size_t k = 0; k < c.outputs; k += M * Lanes::count)
        for (size_t j = 0; j < c.run; j += J)
            outer<Lanes, J, M>(c, j, k);
}

// Adds a row of pixels to the gradient. outputs: a multiple of 8; run: 3 (a single channel) or a multiple of 24.
void correlate(const Correlation &c) noexcept {
    if (c.run == 3)
        return outers<Eight, 3, 1>(c);
    if constexpr (Wide::count > 8)
        if (c.outputs % Wide::count != 0)
            return outers<Eight, 2 * kRuns, 1>(c);
    if constexpr (2 * Wide::count > 8)
        if (c.outputs % (2 * Wide::count) != 0)
            return outers<Wide, 2 * kRuns, 1>(c);
    outers<Wide, kRuns, 2>(c);
}

} // namespace
} // namespace TOLIMAN_ISA
} // namespace toliman::kernels
// NOLINTEND(misc-definitions-in-headers)
