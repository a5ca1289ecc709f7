// Method: `down` computes 2x2 sums of the fine image first and convolves them at every second pixel:
//     mean2x2(conv3x3(x)) at stride 2  =  conv3x3(sum2x2(x)) at stride 2, times 1/4
// since both operators are linear and shift-invariant. It takes 9 products per coarse pixel and pair of channels.
// Convolving every fine pixel and averaging takes 36, the merged 4x4 convolution of stride 2 takes 16. Only three rows
// of sums are kept, so that the extra pass stays in cache. With one fine channel vectors run over pixels of even or odd
// columns, and the eight planes of a row are interleaved at its end: vectors over eight channels would be half empty.
//
// `up` is the adjoint: transposed convolution by output phase (even and odd rows and columns), then 2x2 sums. With one
// fine channel a vector over channels would be mostly empty; there each coarse pixel adds a 4x4 patch, and vectors run
// over the patch. Register tiles are in kernels/conv_tile.hpp. Measured time, and that
// of the products at peak rate: tools/docs/benchmarks.md.
#include "kernels/conv.hpp"

#include "kernels/conv_tile.hpp"
#include "kernels/elu_row.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kEight = 8; // channels of a tile with a single fine channel
#if defined(__AVX512F__)
constexpr size_t kVectors = 2; // of pixels: 16 accumulators
#else
constexpr size_t kVectors = 1;
#endif
constexpr size_t kMaxFloats = 1088; // per row of box sums: 257 x 1, 129 x 8, 65 x 16, 33 x 32

// Box sums of a bordered fine image, row by row: element (r, q) is the sum of rows r, r + 1 and columns q, q + 1 of the
// bordered image. A ring holds the three rows of the current coarse row.
class BoxRows {
  public:
    BoxRows(const ConvShape &shape, const float *fine) noexcept
        : fine_(fine), row_((2 * shape.cols + 2) * shape.fine_channels), channels_(shape.fine_channels) {}

    // The three rows of box sums for coarse row y; call it with y = 0, 1, 2, ...
    void three(size_t y, const float *(&rows)[3]) noexcept {
        for (; next_ < 2 * y + 3; next_++)
            fill(next_);
        for (size_t t = 0; t < 3; t++)
            rows[t] = ring_[(2 * y + t) % 3];
    }

  private:
    void fill(size_t r) noexcept {
        const float *upper = fine_ + r * row_, *lower = upper + row_;
        float *out = ring_[r % 3];
        for (size_t i = 0; i < row_ - channels_; i++)
            out[i] = (upper[i] + lower[i]) + (upper[i + channels_] + lower[i + channels_]);
    }

    const float *fine_;
    size_t row_, channels_, next_ = 0;
    float ring_[3][kMaxFloats];
};

// Box sums of a row with a single channel, apart for even and odd columns: the taps of adjacent coarse pixels are then
// contiguous.
constexpr size_t kPlane = 128 + 2 * Wide::count; // columns, and a tile beyond the last
struct SplitRow {
    float even[kPlane], odd[kPlane];

    void fill(const float *upper, const float *lower, size_t cols) noexcept {
        float sum[2 * kPlane];
        for (size_t i = 0; i < 2 * cols + 2; i++)
            sum[i] = upper[i] + lower[i];
        for (size_t q = 0; q <= cols; q++) {
            even[q] = sum[2 * q] + sum[2 * q + 1];
            odd[q] = sum[2 * q + 1] + sum[2 * q + 2];
        }
    }
};

// Eight output channels of M vectors of adjacent pixels, as planes [8][kPlane]. weights: [9][outputs].
template <size_t M>
inline void single_tile(const SplitRow *const rows[3], size_t pixel, const float *weights, const float *bias,
                        size_t outputs, float *planes) noexcept {
    Wide::Vector sum[kEight][M];
    for (size_t k = 0; k < kEight; k++)
        for (size_t m = 0; m < M; m++)
            sum[k][m] = bias[k] + Wide::Vector{};
    for (size_t r = 0; r < 3; r++) {
        const float *in[3] = {rows[r]->even + pixel, rows[r]->odd + pixel, rows[r]->even + pixel + 1};
#pragma GCC unroll 3
        for (size_t j = 0; j < 3; j++, weights += outputs) {
            Wide::Vector value[M];
            for (size_t m = 0; m < M; m++)
                value[m] = Wide::load(in[j] + m * Wide::count);
#pragma GCC unroll 8
            for (size_t k = 0; k < kEight; k++)
#pragma GCC unroll 2
                for (size_t m = 0; m < M; m++)
                    sum[k][m] += value[m] * weights[k];
        }
    }
    for (size_t k = 0; k < kEight; k++)
        for (size_t m = 0; m < M; m++)
            Wide::store(planes + k * kPlane + pixel + m * Wide::count, sum[k][m]);
}

inline void interleave(const float *planes, size_t pixels, size_t step, float *out) noexcept {
    for (size_t p = 0; p < pixels; p++)
        for (size_t k = 0; k < kEight; k++)
            out[p * step + k] = planes[k * kPlane + p];
}

// A single fine channel: vectors run over pixels. Over the eight channels they would be half empty.
template <bool Elu>
void down_single(const ConvShape &shape, const float *fine, const float *weights, const float *bias,
                 float *coarse) noexcept {
    SplitRow ring[3] = {};
    float planes[kEight * kPlane];
    const size_t row = 2 * shape.cols + 2, outputs = shape.coarse_channels;
    size_t next = 0;
    for (size_t y = 0; y < shape.rows; y++) {
        for (; next < 2 * y + 3; next++)
            ring[next % 3].fill(fine + next * row, fine + (next + 1) * row, shape.cols);
        const SplitRow *const rows[3] = {&ring[2 * y % 3], &ring[(2 * y + 1) % 3], &ring[(2 * y + 2) % 3]};
        float *out = coarse + ((y + 1) * (shape.cols + 2) + 1) * outputs;
        for (size_t first = 0; first < outputs; first += kEight) {
            for (size_t pixel = 0; pixel < shape.cols; pixel += kVectors * Wide::count)
                single_tile<kVectors>(rows, pixel, weights + first, bias + first, outputs, planes);
            if (outputs == kEight)
                interleave(planes, shape.cols, kEight, out); // a constant, for which the loop vectorises
            else
                interleave(planes, shape.cols, outputs, out + first);
        }
        if constexpr (Elu)
            elu(out, shape.cols * outputs);
    }
}

template <bool Elu>
void down(const ConvShape &shape, const float *fine, const float *weights, const float *bias, float *coarse) noexcept {
    if (shape.fine_channels == 1)
        return down_single<Elu>(shape, fine, weights, bias, coarse);
    BoxRows boxes(shape, fine);
    Row row = {};
    row.in_step = 2 * shape.fine_channels;
    row.rows = 3;
    row.run = 3 * shape.fine_channels;
    row.weights = weights;
    row.bias = bias;
    row.out_step = row.outputs = shape.coarse_channels;
    row.pixels = shape.cols;
    for (size_t y = 0; y < shape.rows; y++) {
        const float *rows[3];
        boxes.three(y, rows);
        for (size_t t = 0; t < 3; t++)
            row.in[t] = rows[t];
        row.out = coarse + ((y + 1) * (shape.cols + 2) + 1) * shape.coarse_channels;
        (row.run == 24 ? convolve<24, 16> : convolve<>)(row);
        if constexpr (Elu)
            elu(row.out, row.pixels * row.outputs);
    }
}

void weight_gradient(const ConvShape &shape, const float *fine, const float *coarse, float *packed) noexcept {
    for (size_t i = 0; i < shape.packed(); i++)
        packed[i] = 0;
    BoxRows boxes(shape, fine);
    Correlation c = {};
    c.in_step = 2 * shape.fine_channels;
    c.run = 3 * shape.fine_channels;
    c.outputs = shape.coarse_channels;
    c.pixels = shape.cols;
    c.gradient = packed;
    for (size_t y = 0; y < shape.rows; y++) {
        boxes.three(y, c.in);
        c.out = coarse + ((y + 1) * (shape.cols + 2) + 1) * shape.coarse_channels;
        correlate(c);
    }
}

// One row of the transposed convolution before its box sums, columns -1 ... 2 cols - 1. Even row 2 Y is coarse row Y
// times the kernel's middle row; odd row 2 Y + 1 combines coarse rows Y and Y + 1. The same holds for columns.
void transposed_row(const ConvShape &shape, const float *const coarse[2], size_t rows, const float *weights,
                    float *out) noexcept {
    const size_t from = shape.coarse_channels, to = shape.fine_channels;
    Row row = {};
    row.in_step = from;
    row.rows = rows;
    row.weights = weights;
    row.out_step = 2 * to;
    row.outputs = to;
    for (size_t taps = 1; taps <= 2; taps++) { // even columns, then odd columns, which are one more
        for (size_t r = 0; r < rows; r++)
            row.in[r] = coarse[r] + (taps == 1 ? from : 0);
        row.run = taps * from;
        row.out = out + (taps == 1 ? to : 0);
        row.pixels = shape.cols + taps - 1;
        convolve<>(row);
        row.weights += rows * row.run * to;
    }
}

// out: sums of adjacent columns.
void column_sums(const float *row, size_t floats, size_t channels, float *out) noexcept {
    for (size_t i = 0; i < floats; i++)
        out[i] = row[i] + row[i + channels];
}

void up_channels(const ConvShape &shape, const float *coarse, const float *weights, const float *bias,
                 float *fine) noexcept {
    const size_t coarse_row = (shape.cols + 2) * shape.coarse_channels, channels = shape.fine_channels;
    const size_t floats = 2 * shape.cols * channels;
    const float *odd_weights = weights + 3 * shape.coarse_channels * channels;
    float row[kMaxFloats], sums[2][kMaxFloats], biases[kMaxFloats];
    for (size_t k = 0; k < floats; k++)
        biases[k] = bias[k % channels];
    for (size_t i = 0; i <= 2 * shape.rows; i++) { // row i - 1 of the transposed convolution
        const float *rows[2] = {coarse + (i + 1) / 2 * coarse_row, coarse + (i / 2 + 1) * coarse_row};
        const bool odd = i % 2 == 0;
        transposed_row(shape, rows, odd ? 2 : 1, odd ? odd_weights : weights, row);
        column_sums(row, floats, channels, sums[i % 2]);
        float *out = fine + (i * (2 * shape.cols + 2) + 1) * channels;
        for (size_t k = 0; i > 0 && k < floats; k++)
            out[k] = (sums[0][k] + sums[1][k]) + biases[k];
    }
}

// A single fine channel: each coarse pixel adds a patch of 4x4 fine pixels, which overlaps the next patch by two rows
// or columns. The floats of a patch are in the order [right half][lower half][row][column], so that overlapping halves
// are contiguous.
constexpr size_t kPatch = 16, kHalf = 8, kQuarter = 4, kMaxCols = 130;

// Sums the patches of a bordered coarse row where they overlap: out [cols + 1][8], fine columns 2 q - 1 and 2 q.
void patch_row(const ConvShape &shape, const float *coarse, const float *weights, float *out) noexcept {
    float patches[kMaxCols * kPatch];
    Row row = {};
    row.in[0] = coarse;
    row.in_step = row.run = shape.coarse_channels;
    row.rows = 1;
    row.weights = weights;
    row.out = patches;
    row.out_step = row.outputs = kPatch;
    row.pixels = shape.cols + 2;
    convolve<>(row);
    for (size_t q = 0; q <= shape.cols; q++)
        for (size_t i = 0; i < kHalf; i++)
            // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): convolve has filled them
            out[q * kHalf + i] = patches[q * kPatch + kHalf + i] + patches[(q + 1) * kPatch + i];
}

void clear_border(size_t rows, size_t cols, float *image) noexcept {
    for (size_t c = 0; c < cols; c++)
        image[c] = image[(rows - 1) * cols + c] = 0;
    for (size_t r = 0; r < rows; r++)
        image[r * cols] = image[(r + 1) * cols - 1] = 0;
}

void up_single(const ConvShape &shape, const float *coarse, const float *weights, const float *bias,
               float *fine) noexcept {
    typedef float Pair __attribute__((vector_size(8), aligned(4), may_alias));
    const size_t fine_row = 2 * shape.cols + 2;
    float row_sums[2][kMaxCols * kHalf];
    patch_row(shape, coarse, weights, row_sums[0]);
    for (size_t y = 0; y <= shape.rows; y++) {
        const float *above = row_sums[y % 2], *below = row_sums[(y + 1) % 2];
        patch_row(shape, coarse + (y + 1) * (shape.cols + 2) * shape.coarse_channels, weights, row_sums[(y + 1) % 2]);
        for (size_t r = 0; r < 2; r++)
            for (size_t q = 0; q <= shape.cols; q++)
                *reinterpret_cast<Pair *>(fine + (2 * y + r) * fine_row + 2 * q) =
                    *reinterpret_cast<const Pair *>(above + q * kHalf + kQuarter + 2 * r) +
                    *reinterpret_cast<const Pair *>(below + q * kHalf + 2 * r) + bias[0];
    }
    clear_border(2 * shape.rows + 2, fine_row, fine);
}

void up(const ConvShape &shape, const float *coarse, const float *weights, const float *bias, float *fine) noexcept {
    (shape.fine_channels == 1 ? up_single : up_channels)(shape, coarse, weights, bias, fine);
}

} // namespace
} // namespace TOLIMAN_ISA

const ConvKernels TOLIMAN_ISA_TABLE(conv) = {TOLIMAN_ISA::down<false>, TOLIMAN_ISA::down<true>, TOLIMAN_ISA::up,
                                             TOLIMAN_ISA::weight_gradient};

} // namespace toliman::kernels
