#include "kernels/conv.hpp"

#include "kernels/conv_tile.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kMostFloats = 1088; // of a row of box sums: 257 x 1, 129 x 8, 65 x 16, 33 x 32

// Box sums of a bordered fine image, row by row: row r, column q is the sum of pixels r, r + 1 and q, q + 1 of the
// bordered image. The mean and the 3x3 convolution commute with the stride, so that the convolution of them with every
// second pixel left out is what `down` asks for, with 9 products a weight instead of 16.
class BoxRows {
  public:
    BoxRows(const ConvShape &shape, const float *fine) noexcept
        : fine_(fine), row_((2 * shape.cols + 2) * shape.fine_channels), channels_(shape.fine_channels) {}

    // The three rows that coarse row y meets; must be asked for in turn.
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
    float ring_[3][kMostFloats];
};

void down(const ConvShape &shape, const float *fine, const float *weights, const float *bias, float *coarse) noexcept {
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
        (row.run == 3 ? convolve<3> : convolve<>)(row);
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

// One row of the transposed convolution before its box sums, columns -1 ... 2 cols - 1: even row 2 Y from coarse row Y
// by the kernel's middle row, odd row 2 Y + 1 from rows Y and Y + 1; columns alike.
void transposed_row(const ConvShape &shape, const float *const coarse[2], size_t rows, const float *weights,
                    float *out) noexcept {
    const size_t from = shape.coarse_channels, to = shape.fine_channels;
    Row row = {};
    row.in_step = from;
    row.rows = rows;
    row.weights = weights;
    row.out_step = 2 * to;
    row.outputs = to;
    for (size_t taps = 1; taps <= 2; taps++) { // even columns, then odd ones, of which there is one more
        for (size_t r = 0; r < rows; r++)
            row.in[r] = coarse[r] + (taps == 1 ? from : 0);
        row.run = taps * from;
        row.out = out + (taps == 1 ? to : 0);
        row.pixels = shape.cols + taps - 1;
        convolve<>(row);
        row.weights += rows * row.run * to;
    }
}

// out = pairs of neighbouring columns, summed.
void column_sums(const float *row, size_t floats, size_t channels, float *out) noexcept {
    for (size_t i = 0; i < floats; i++)
        out[i] = row[i] + row[i + channels];
}

void up_channels(const ConvShape &shape, const float *coarse, const float *weights, const float *bias,
                 float *fine) noexcept {
    const size_t coarse_row = (shape.cols + 2) * shape.coarse_channels, channels = shape.fine_channels;
    const size_t floats = 2 * shape.cols * channels;
    const float *odd_weights = weights + 3 * shape.coarse_channels * channels;
    float row[kMostFloats], sums[2][kMostFloats], biases[kMostFloats];
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

// A single fine channel: each coarse pixel paints a patch of 4x4 fine ones, of which every second row and column is
// shared with the next patch. The floats of a patch stand in the order of halves, so that shared ones add as they are:
// [right half][lower half][row][column].
constexpr size_t kPatch = 16, kHalf = 8, kQuarter = 4, kMostCols = 130;

// Patches of a bordered coarse row, joined from left to right: out [cols + 1][8] are fine columns 2 q - 1 and 2 q.
void patch_row(const ConvShape &shape, const float *coarse, const float *weights, float *out) noexcept {
    float patches[kMostCols * kPatch];
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
    float joined[2][kMostCols * kHalf];
    patch_row(shape, coarse, weights, joined[0]);
    for (size_t y = 0; y <= shape.rows; y++) {
        const float *above = joined[y % 2], *below = joined[(y + 1) % 2];
        patch_row(shape, coarse + (y + 1) * (shape.cols + 2) * shape.coarse_channels, weights, joined[(y + 1) % 2]);
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

const ConvKernels TOLIMAN_ISA_TABLE(conv) = {TOLIMAN_ISA::down, TOLIMAN_ISA::up, TOLIMAN_ISA::weight_gradient};

} // namespace toliman::kernels
