#include "kernels/conv.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Vectors run over channels and may stand at any address.
#define TOLIMAN_LANES(N)                                                                                               \
    struct Lanes##N {                                                                                                  \
        typedef float Vector __attribute__((vector_size(4 * (N)), aligned(4), may_alias));                             \
        [[maybe_unused]] static constexpr size_t count = N;                                                            \
    }
TOLIMAN_LANES(4);
#if defined(__AVX512F__)
TOLIMAN_LANES(8);
TOLIMAN_LANES(16);
using Wide = Lanes16;
constexpr size_t kPixels = 8; // of a tile two vectors wide: 16 sums, two weights and an input fit 32 registers
#elif defined(__AVX__)
TOLIMAN_LANES(8);
using Wide = Lanes8;
constexpr size_t kPixels = 4;
#else
using Wide = Lanes4;
constexpr size_t kPixels = 4;
#endif
#undef TOLIMAN_LANES

// One row of output pixels, each the sum over `rows` runs of `run` neighbouring floats of the input times the weights.
struct Row {
    const float *in;
    size_t in_row, in_step; // floats from one run to the next, and from one output pixel to the next
    size_t rows, run;
    const float *weights; // [rows][run][outputs]
    const float *bias;    // [outputs]
    float *out;
    size_t out_step, outputs, pixels;
};

// Output channels first ... first + M lanes of P neighbouring pixels, all sums in registers.
template <class Lanes, size_t P, size_t M> void tile(const Row &row, size_t pixel, size_t first) noexcept {
    using Vector = typename Lanes::Vector;
    Vector sum[P][M];
    for (size_t p = 0; p < P; p++)
        for (size_t m = 0; m < M; m++)
            sum[p][m] = *reinterpret_cast<const Vector *>(row.bias + first + m * Lanes::count);
    const float *weights = row.weights + first;
    for (size_t r = 0; r < row.rows; r++) {
        const float *in = row.in + r * row.in_row + pixel * row.in_step;
        for (size_t j = 0; j < row.run; j++, in++, weights += row.outputs) {
            Vector weight[M];
#pragma GCC unroll 16
            for (size_t m = 0; m < M; m++)
                weight[m] = *reinterpret_cast<const Vector *>(weights + m * Lanes::count);
#pragma GCC unroll 16
            for (size_t p = 0; p < P; p++)
#pragma GCC unroll 16
                for (size_t m = 0; m < M; m++)
                    sum[p][m] += weight[m] * in[p * row.in_step];
        }
    }
    float *out = row.out + pixel * row.out_step + first;
    for (size_t p = 0; p < P; p++)
        for (size_t m = 0; m < M; m++)
            *reinterpret_cast<Vector *>(out + p * row.out_step + m * Lanes::count) = sum[p][m];
}

template <class Lanes, size_t P, size_t M> void tiles(const Row &row) noexcept {
    for (size_t first = 0; first < row.outputs; first += M * Lanes::count)
        for (size_t pixel = 0; pixel < row.pixels; pixel += P)
            tile<Lanes, P, M>(row, pixel, first);
}

// A single output channel: 16 partial sums along the runs (a multiple of 16 floats), then halved four times.
void single(const Row &row) noexcept {
    using Vector = Wide::Vector;
    constexpr size_t M = 16 / Wide::count;
    for (size_t pixel = 0; pixel < row.pixels; pixel++) {
        Vector sum[M] = {};
        for (size_t r = 0; r < row.rows; r++) {
            const float *in = row.in + r * row.in_row + pixel * row.in_step, *weights = row.weights + r * row.run;
            for (size_t j = 0; j < row.run; j += 16)
                for (size_t m = 0; m < M; m++)
                    sum[m] += *reinterpret_cast<const Vector *>(in + j + m * Wide::count) *
                              *reinterpret_cast<const Vector *>(weights + j + m * Wide::count);
        }
        float part[16];
        for (size_t m = 0; m < M; m++)
            *reinterpret_cast<Vector *>(part + m * Wide::count) = sum[m];
        const auto *four = reinterpret_cast<const Lanes4::Vector *>(part);
        const Lanes4::Vector rest = (four[0] + four[2]) + (four[1] + four[3]);
        row.out[pixel * row.out_step] = row.bias[0] + ((rest[0] + rest[2]) + (rest[1] + rest[3]));
    }
}

void convolve(const Row &row) noexcept {
    if (row.outputs == 1)
        return single(row);
    if (row.outputs % (2 * Wide::count) == 0)
        return tiles<Wide, kPixels, 2>(row);
    if (row.outputs % Wide::count == 0)
        return tiles<Wide, 8, 1>(row);
#if defined(__AVX512F__)
    tiles<Lanes8, 8, 1>(row);
#endif
}

void down(const ConvShape &shape, const float *fine, const float *weights, const float *bias, float *coarse) noexcept {
    const size_t fine_row = (2 * shape.cols + 2) * shape.fine_channels;
    const size_t coarse_row = (shape.cols + 2) * shape.coarse_channels;
    Row row = {};
    row.in_row = fine_row;
    row.in_step = 2 * shape.fine_channels;
    row.rows = 4;
    row.run = 4 * shape.fine_channels;
    row.weights = weights;
    row.bias = bias;
    row.out_step = row.outputs = shape.coarse_channels;
    row.pixels = shape.cols;
    for (size_t y = 0; y < shape.rows; y++) {
        row.in = fine + 2 * y * fine_row;
        row.out = coarse + (y + 1) * coarse_row + shape.coarse_channels;
        convolve(row);
    }
}

void up(const ConvShape &shape, const float *coarse, const float *weights, const float *bias, float *fine) noexcept {
    const size_t fine_row = (2 * shape.cols + 2) * shape.fine_channels;
    const size_t coarse_row = (shape.cols + 2) * shape.coarse_channels;
    Row row = {};
    row.in_row = coarse_row;
    row.in_step = shape.coarse_channels;
    row.rows = 2;
    row.run = 2 * shape.coarse_channels;
    row.bias = bias;
    row.out_step = 2 * shape.fine_channels;
    row.outputs = shape.fine_channels;
    row.pixels = shape.cols;
    for (size_t phase = 0; phase < 4; phase++) {
        const size_t a = phase / 2, b = phase % 2;
        row.weights = weights + phase * shape.packed() / 4;
        for (size_t y = 0; y < shape.rows; y++) {
            row.in = coarse + (y + a) * coarse_row + b * shape.coarse_channels;
            row.out = fine + (2 * y + a + 1) * fine_row + (b + 1) * shape.fine_channels;
            convolve(row);
        }
    }
}

// Adds to gradient [J][outputs] the products of J floats of the fine row with M lanes of the coarse row's channels.
template <class Lanes, size_t J, size_t M>
void outer(const float *fine, size_t fine_step, const float *coarse, size_t coarse_step, size_t pixels,
           float *gradient) noexcept {
    using Vector = typename Lanes::Vector;
    Vector sum[J][M];
    for (size_t j = 0; j < J; j++)
        for (size_t m = 0; m < M; m++)
            sum[j][m] = *reinterpret_cast<const Vector *>(gradient + j * coarse_step + m * Lanes::count);
    for (size_t x = 0; x < pixels; x++, fine += fine_step, coarse += coarse_step) {
        Vector value[M];
#pragma GCC unroll 16
        for (size_t m = 0; m < M; m++)
            value[m] = *reinterpret_cast<const Vector *>(coarse + m * Lanes::count);
#pragma GCC unroll 16
        for (size_t j = 0; j < J; j++)
#pragma GCC unroll 16
            for (size_t m = 0; m < M; m++)
                sum[j][m] += value[m] * fine[j];
    }
    for (size_t j = 0; j < J; j++)
        for (size_t m = 0; m < M; m++)
            *reinterpret_cast<Vector *>(gradient + j * coarse_step + m * Lanes::count) = sum[j][m];
}

template <class Lanes, size_t J, size_t M>
void outers(const ConvShape &shape, const float *fine, const float *coarse, float *gradient) noexcept {
    const size_t run = 4 * shape.fine_channels, outputs = shape.coarse_channels;
    for (size_t j = 0; j < run; j += J)
        for (size_t k = 0; k < outputs; k += M * Lanes::count)
            outer<Lanes, J, M>(fine + j, 2 * shape.fine_channels, coarse + k, outputs, shape.cols,
                               gradient + j * outputs + k);
}

void weight_gradient(const ConvShape &shape, const float *fine, const float *coarse, float *packed) noexcept {
    const size_t fine_row = (2 * shape.cols + 2) * shape.fine_channels;
    const size_t coarse_row = (shape.cols + 2) * shape.coarse_channels;
    for (size_t i = 0; i < shape.packed(); i++)
        packed[i] = 0;
    for (size_t y = 0; y < shape.rows; y++)
        for (size_t u = 0; u < 4; u++) {
            const float *in = fine + (2 * y + u) * fine_row;
            const float *out = coarse + (y + 1) * coarse_row + shape.coarse_channels;
            float *gradient = packed + u * shape.packed() / 4;
            if (shape.coarse_channels % (2 * Wide::count) == 0)
                outers<Wide, 4, 2>(shape, in, out, gradient);
            else if (shape.coarse_channels % Wide::count == 0)
                outers<Wide, 4, 1>(shape, in, out, gradient);
#if defined(__AVX512F__)
            else
                outers<Lanes8, 4, 1>(shape, in, out, gradient);
#endif
        }
}

} // namespace
} // namespace TOLIMAN_ISA

const ConvKernels TOLIMAN_ISA_TABLE(conv) = {TOLIMAN_ISA::down, TOLIMAN_ISA::up, TOLIMAN_ISA::weight_gradient};

} // namespace toliman::kernels
