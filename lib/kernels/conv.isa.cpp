// Method: `down` computes 2x2 sums of the fine image first and convolves them at every second pixel:
//     mean2x2(conv3x3(x)) at stride 2  =  conv3x3(sum2x2(x)) at stride 2, times 1/4
// since both operators are linear and shift-invariant. It takes 9 products per coarse pixel and pair of channels.
// Convolving every fine pixel and averaging takes 36, the merged 4x4 convolution of stride 2 takes 16. Only three rows
// of sums are kept, so that the extra pass stays in cache. With one fine channel vectors run over pixels of even or odd
// columns, and the eight channels of a tile are interleaved at its end: vectors over eight channels would be half
// empty.
//
// `up` is the adjoint: transposed convolution by output phase (even and odd rows and columns), then 2x2 sums. With one
// fine channel a vector over channels would be mostly empty; there each coarse pixel adds a 4x4 patch, and vectors run
// over the patch. Register tiles are in kernels/conv_tile.hpp. Measured times: tools/docs/benchmarks.md.
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

// Element i is element from[i] of a followed by b.
inline Wide::Vector shuffled(Wide::Vector a, Wide::Vector b, Wide::Mask from) noexcept {
#if defined(__clang__) // which has no shuffle by a vector
    constexpr int n = Wide::count;
    Wide::Vector result = {};
    for (int i = 0; i < n; i++)
        result[i] = from[i] < n ? a[from[i]] : b[from[i] - n];
    return result;
#else
    return __builtin_shuffle(a, b, from);
#endif
}

// Sums of adjacent rows and columns of two bordered rows: element q is the sum of columns q and q + 1 of both.
inline void sum_boxes(const float *upper, const float *lower, size_t floats, size_t channels, float *out) noexcept {
    for (size_t i = 0; i < floats; i++)
        out[i] = (upper[i] + lower[i]) + (upper[i + channels] + lower[i + channels]);
}

#if defined(__AVX512F__)
// The same for eight channels, half a vector: shifting sums between registers saves loads that cross a cache line.
void sum_eight(const float *upper, const float *lower, size_t cols, float *out) noexcept {
    const Wide::Mask shift = {8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23};
    Wide::Vector sum = Wide::load(upper) + Wide::load(lower);
    for (size_t i = 0; i < 16 * cols; i += 16) {
        const Wide::Vector next = Wide::load(upper + i + 16) + Wide::load(lower + i + 16);
        Wide::store(out + i, sum + shuffled(sum, next, shift));
        sum = next;
    }
    sum_boxes(upper + 16 * cols, lower + 16 * cols, 8, 8, out + 16 * cols);
}
#else
void sum_eight(const float *upper, const float *lower, size_t cols, float *out) noexcept {
    sum_boxes(upper, lower, (2 * cols + 1) * 8, 8, out);
}
#endif

// The same for a single channel, as a plane of even and a plane of odd columns: the taps of adjacent coarse pixels are
// then contiguous.
constexpr size_t kPlane = 160; // 128 columns, and a tile beyond the last
static_assert(kPlane >= 128 + 2 * Wide::count && 2 * kPlane <= kBoxFloats);
void sum_split_boxes(const float *upper, const float *lower, size_t cols, float *planes) noexcept {
    float sum[2 * kPlane], *even = planes, *odd = planes + kPlane;
    for (size_t i = 0; i < 2 * cols + 2; i++)
        sum[i] = upper[i] + lower[i];
    for (size_t q = 0; q <= cols; q++) {
        even[q] = sum[2 * q] + sum[2 * q + 1];
        odd[q] = sum[2 * q + 1] + sum[2 * q + 2];
    }
}

void box_row(const ConvShape &shape, const float *upper, const float *lower, float *boxes) noexcept {
    if (shape.fine_channels == 1)
        sum_split_boxes(upper, lower, shape.cols, boxes);
    else if (shape.fine_channels == 8)
        sum_eight(upper, lower, shape.cols, boxes);
    else
        sum_boxes(upper, lower, (2 * shape.cols + 1) * shape.fine_channels, shape.fine_channels, boxes);
}

// The three rows of box sums of each coarse row of a bordered fine image.
template <class Sum> class BoxRows {
  public:
    BoxRows(const ConvShape &shape, const float *fine, Sum sum) noexcept
        : fine_(fine), row_((2 * shape.cols + 2) * shape.fine_channels), sum_(sum) {}

    // Those of coarse row y; call it with y = 0, 1, 2, ...
    void three(size_t y, const float *(&boxes)[3]) noexcept {
        for (; next_ < 2 * y + 3; next_++)
            sum_(fine_ + next_ * row_, fine_ + (next_ + 1) * row_, ring_[next_ % 3]);
        for (size_t t = 0; t < 3; t++)
            boxes[t] = ring_[(2 * y + t) % 3];
    }

  private:
    const float *fine_;
    size_t row_, next_ = 0;
    Sum sum_;
    alignas(64) float ring_[3][kBoxFloats] = {};
};

// Interleaves eight vectors: element i of vector k becomes element 8 i + k of all. Three perfect shuffles of the
// vectors k and k + 4.
inline void interleave(Wide::Vector (&v)[kEight]) noexcept {
    constexpr int n = Wide::count;
    Wide::Mask low, high;
    for (int i = 0; i < n; i++) {
        low[i] = i / 2 + i % 2 * n;
        high[i] = (n + i) / 2 + i % 2 * n;
    }
    for (int turn = 0; turn < 3; turn++) {
        Wide::Vector next[kEight];
        for (size_t k = 0; k < kEight / 2; k++) {
            next[2 * k] = shuffled(v[k], v[k + kEight / 2], low);
            next[2 * k + 1] = shuffled(v[k], v[k + kEight / 2], high);
        }
        for (size_t k = 0; k < kEight; k++)
            v[k] = next[k];
    }
}

// Eight output channels of kVectors vectors of adjacent pixels; the first `pixels` of them are stored.
inline void single_tile(const float *const boxes[3], size_t pixel, size_t pixels, const float *weights,
                        const float *bias, size_t outputs, float *out) noexcept {
    Wide::Vector sum[kVectors][kEight];
    for (size_t m = 0; m < kVectors; m++)
        for (size_t k = 0; k < kEight; k++)
            sum[m][k] = bias[k] + Wide::Vector{};
    for (size_t r = 0; r < 3; r++) {
        const float *even = boxes[r] + pixel, *in[3] = {even, even + kPlane, even + 1};
#pragma GCC unroll 3
        for (size_t j = 0; j < 3; j++, weights += outputs) {
            Wide::Vector value[kVectors];
            for (size_t m = 0; m < kVectors; m++)
                value[m] = Wide::load(in[j] + m * Wide::count);
#pragma GCC unroll 8
            for (size_t k = 0; k < kEight; k++)
#pragma GCC unroll 2
                for (size_t m = 0; m < kVectors; m++)
                    sum[m][k] += value[m] * weights[k];
        }
    }
    float block[kVectors * Wide::count * kEight], *const to = outputs == kEight && pixels == kVectors * Wide::count
                                                                  ? out
                                                                  : block;
    for (size_t m = 0; m < kVectors; m++) {
        interleave(sum[m]);
        for (size_t k = 0; k < kEight; k++)
            Wide::store(to + (m * kEight + k) * Wide::count, sum[m][k]);
    }
    for (size_t p = 0; to == block && p < pixels; p++)
        for (size_t k = 0; k < kEight; k++)
            out[p * outputs + k] = block[p * kEight + k];
}

// A single fine channel: vectors run over pixels. Over the eight channels they would be half empty.
void single_row(const ConvShape &shape, const float *const boxes[3], const float *weights, const float *bias,
                float *out) noexcept {
    constexpr size_t kTile = kVectors * Wide::count;
    const size_t outputs = shape.coarse_channels;
    for (size_t first = 0; first < outputs; first += kEight)
        for (size_t pixel = 0; pixel < shape.cols; pixel += kTile)
            single_tile(boxes, pixel, shape.cols - pixel < kTile ? shape.cols - pixel : kTile, weights + first,
                        bias + first, outputs, out + pixel * outputs + first);
}

template <bool Elu>
void down_row(const ConvShape &shape, const float *const boxes[3], const float *weights, const float *bias,
              float *out) noexcept {
    Row row = {};
    row.in_step = 2 * shape.fine_channels;
    row.rows = 3;
    row.run = 3 * shape.fine_channels;
    row.weights = weights;
    row.bias = bias;
    row.out = out;
    row.out_step = row.outputs = shape.coarse_channels;
    row.pixels = shape.cols;
    for (size_t t = 0; t < 3; t++)
        row.in[t] = boxes[t];
    if (shape.fine_channels == 1)
        single_row(shape, boxes, weights, bias, out);
    else if (row.run == 24)
        convolve<24, 16>(row);
    else if (row.run == 48)
        convolve<48, 32>(row);
    else if (row.run == 96)
        convolve<96, 64>(row);
    else
        convolve<>(row);
    if constexpr (Elu)
        elu(out, row.pixels * row.outputs);
}

template <bool Elu>
void down(const ConvShape &shape, const float *fine, const float *weights, const float *bias, float *coarse) noexcept {
    BoxRows rows(shape, fine,
                 [&](const float *upper, const float *lower, float *boxes) { box_row(shape, upper, lower, boxes); });
    for (size_t y = 0; y < shape.rows; y++) {
        const float *boxes[3];
        rows.three(y, boxes);
        down_row<Elu>(shape, boxes, weights, bias, coarse + ((y + 1) * (shape.cols + 2) + 1) * shape.coarse_channels);
    }
}

void weight_gradient(const ConvShape &shape, const float *fine, const float *coarse, float *packed) noexcept {
    for (size_t i = 0; i < shape.packed(); i++)
        packed[i] = 0;
    BoxRows rows(shape, fine, [&](const float *upper, const float *lower, float *boxes) {
        sum_boxes(upper, lower, (2 * shape.cols + 1) * shape.fine_channels, shape.fine_channels, boxes);
    });
    Correlation c = {};
    c.in_step = 2 * shape.fine_channels;
    c.run = 3 * shape.fine_channels;
    c.outputs = shape.coarse_channels;
    c.pixels = shape.cols;
    c.gradient = packed;
    for (size_t y = 0; y < shape.rows; y++) {
        rows.three(y, c.in);
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
    float row[kBoxFloats], sums[2][kBoxFloats], biases[kBoxFloats];
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

const ConvKernels TOLIMAN_ISA_TABLE(conv) = {TOLIMAN_ISA::down<false>, TOLIMAN_ISA::down<true>,
                                             TOLIMAN_ISA::box_row,     TOLIMAN_ISA::down_row<true>,
                                             TOLIMAN_ISA::up,          TOLIMAN_ISA::weight_gradient};

} // namespace toliman::kernels
