// Method: between images of several channels, Winograd's minimal filtering F(2x2, 3x3). For each 2x2 block of output
// pixels, with the 4x4 input patch d and the kernel g,
//     Y = A^T [sum over channels of (G g G^T) * (B^T d B)] A,    * element-wise
// which takes 16 products per pair of channels instead of 36 in the direct form. The transforms of d and Y need
// additions only and are shared by all pairs of channels. Eight patches are transformed together, so that the products
// are matrix products of the shape that conv_tile.hpp also uses. Pooling takes the maximum of the block while it is in
// registers.
//
// Images of a single channel use the direct form: their sums are too short to repay the transforms. Larger blocks, such
// as F(4x4, 3x3), need fewer products but lose precision. Measured: encoding 0.95 ms per frame, 1.80 times the time of
// the products at peak rate (one AVX-512 core); oneDNN 2.6 takes 2.5 times as long (tools/docs/benchmarks.md).
//
// Reference: Lavin and Gray (2016), "Fast algorithms for convolutional neural networks", CVPR.
#include "kernels/same_conv.hpp"

#include "kernels/conv_tile.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Floats per row of a bordered image.
size_t row_of(size_t cols, size_t channels) noexcept {
    return (cols + 2) * channels;
}

// Direct form for a single output channel: eight partial sums along the runs (multiples of 8 floats), added pairwise.
void single(const Row &row) noexcept {
    constexpr size_t M = 8 / Eight::count;
    for (size_t pixel = 0; pixel < row.pixels; pixel++) {
        typename Eight::Vector sum[M] = {};
        for (size_t r = 0; r < row.rows; r++) {
            const float *in = row.in[r] + pixel * row.in_step, *weights = row.weights + r * row.run;
            for (size_t j = 0; j < row.run; j += 8)
                for (size_t m = 0; m < M; m++)
                    sum[m] += Eight::load(in + j + m * Eight::count) * Eight::load(weights + j + m * Eight::count);
        }
        float part[8];
        for (size_t m = 0; m < M; m++)
            Eight::store(part + m * Eight::count, sum[m]);
        const Lanes4::Vector half = Lanes4::load(part) + Lanes4::load(part + 4);
        row.out[pixel] = (row.bias != nullptr ? row.bias[0] : 0.0f) + ((half[0] + half[2]) + (half[1] + half[3]));
    }
}

// Maximum and its position; the first of equal values.
template <class Lanes> struct Best {
    typename Lanes::Vector value;
    typename Lanes::Mask from;
    static Best of(const Best &a, const Best &b) noexcept {
        const auto second = b.value > a.value;
        return {second ? b.value : a.value, second ? b.from : a.from};
    }
    static Best of_four(const typename Lanes::Vector (&v)[4]) noexcept {
        const typename Lanes::Mask zero = {};
        return of(of({v[0], zero}, {v[1], zero + 1}), of({v[2], zero + 2}, {v[3], zero + 3}));
    }
};

// Destination of the 2x2 blocks of a result: the pixels themselves, or their maxima and switches.
struct Output {
    const float *bias; // or NULL
    float *pixel[2];   // the two rows of pixels, or NULL
    float *pooled;     // maxima, or NULL
    Switch *switches;  // positions of the maxima, or NULL
    size_t channels;
};

template <class Lanes>
void store_block(const Output &to, size_t coarse, size_t channel, typename Lanes::Vector (&v)[4]) noexcept {
    typename Lanes::Vector bias = {};
    if (to.bias != nullptr)
        bias = Lanes::load(to.bias + channel);
    if (to.pooled == nullptr) {
        for (size_t i = 0; i < 4; i++)
            Lanes::store(to.pixel[i / 2] + (2 * coarse + i % 2) * to.channels + channel, v[i] + bias);
        return;
    }
    const Best<Lanes> best = Best<Lanes>::of_four(v);
    Lanes::store(to.pooled + coarse * to.channels + channel, best.value + bias);
    if (to.switches != nullptr)
        Lanes::store(to.switches + coarse * to.channels + channel, best.from);
}

constexpr size_t kTiles = 8, kMaxChannels = 64; // 2x2 blocks transformed together

// Input transform B^T d B of kTiles patches of 4x4 pixels, two columns apart: out [16][kTiles][channels].
template <class Lanes> void winograd_in(const float *const (&rows)[4], size_t channels, float *out) noexcept {
    using Vector = typename Lanes::Vector;
    const size_t each = kTiles * channels;
    for (size_t c = 0; c < channels; c += Lanes::count) {
        Vector column[4][4]; // [column of the patch][row of B^T d]; the last two belong to the next patch too
        const auto fill = [&](size_t x, Vector(&to)[4]) {
            Vector d[4];
            for (size_t r = 0; r < 4; r++)
                d[r] = Lanes::load(rows[r] + x * channels + c);
            to[0] = d[0] - d[2];
            to[1] = d[1] + d[2];
            to[2] = d[2] - d[1];
            to[3] = d[1] - d[3];
        };
        fill(0, column[0]);
        fill(1, column[1]);
        for (size_t t = 0; t < kTiles; t++) {
            fill(2 * t + 2, column[2]);
            fill(2 * t + 3, column[3]);
            float *to = out + t * channels + c;
            for (size_t r = 0; r < 4; r++) {
                Lanes::store(to + 4 * r * each, column[0][r] - column[2][r]);
                Lanes::store(to + (4 * r + 1) * each, column[1][r] + column[2][r]);
                Lanes::store(to + (4 * r + 2) * each, column[2][r] - column[1][r]);
                Lanes::store(to + (4 * r + 3) * each, column[1][r] - column[3][r]);
                column[0][r] = column[2][r];
                column[1][r] = column[3][r];
            }
        }
    }
}

// Products [16][kTiles][channels] of patches [16][kTiles][in_channels] and weights [16][in_channels][channels].
template <class Lanes, size_t P, size_t M>
void products_of(const float *patches, size_t in_channels, const float *weights, size_t channels,
                 float *products) noexcept {
    for (size_t first = 0; first < channels; first += M * Lanes::count)
        for (size_t i = 0; i < 16; i++)
            for (size_t t = 0; t < kTiles; t += P) {
                const float *in = patches + (i * kTiles + t) * in_channels;
                const float *weight_row = weights + i * in_channels * channels + first;
                typename Lanes::Vector sum[P][M] = {};
                for (size_t c = 0; c < in_channels; c++, in++, weight_row += channels) {
                    typename Lanes::Vector weight[M];
#pragma GCC unroll 16
                    for (size_t m = 0; m < M; m++)
                        weight[m] = Lanes::load(weight_row + m * Lanes::count);
#pragma GCC unroll 16
                    for (size_t p = 0; p < P; p++)
#pragma GCC unroll 16
                        for (size_t m = 0; m < M; m++)
                            sum[p][m] += weight[m] * in[p * in_channels];
                }
                float *out = products + (i * kTiles + t) * channels + first;
                for (size_t p = 0; p < P; p++)
                    for (size_t m = 0; m < M; m++)
                        Lanes::store(out + p * channels + m * Lanes::count, sum[p][m]);
            }
}

void multiply(const float *patches, size_t in_channels, const float *weights, size_t channels,
              float *products) noexcept {
    if constexpr (Wide::count > 8)
        if (channels % Wide::count != 0)
            return products_of<Eight, 8, 1>(patches, in_channels, weights, channels, products);
    if constexpr (2 * Wide::count > 8)
        if (channels % (2 * Wide::count) != 0)
            return products_of<Wide, 8, 1>(patches, in_channels, weights, channels, products);
    products_of<Wide, kPixels, 2>(patches, in_channels, weights, channels, products);
}

// Output transform A^T m A of kTiles products [16][kTiles][channels], stored to their destination.
template <class Lanes> void winograd_out(const float *products, const Output &to, size_t coarse) noexcept {
    using Vector = typename Lanes::Vector;
    const size_t each = kTiles * to.channels;
    for (size_t t = 0; t < kTiles; t++)
        for (size_t k = 0; k < to.channels; k += Lanes::count) {
            const float *from = products + t * to.channels + k;
            Vector upper[4], lower[4];
            for (size_t s = 0; s < 4; s++) {
                const Vector m1 = Lanes::load(from + (4 + s) * each), m2 = Lanes::load(from + (8 + s) * each);
                upper[s] = Lanes::load(from + s * each) + m1 + m2;
                lower[s] = m1 - m2 - Lanes::load(from + (12 + s) * each);
            }
            Vector v[4] = {upper[0] + upper[1] + upper[2], upper[1] - upper[2] - upper[3],
                           lower[0] + lower[1] + lower[2], lower[1] - lower[2] - lower[3]};
            store_block<Lanes>(to, coarse + t, k, v);
        }
}

// Two rows of the result from four rows of the input; pixels: number of 2x2 blocks.
void winograd_rows(const float *const (&rows)[4], size_t in_channels, const float *weights, size_t pixels,
                   const Output &to) noexcept {
    float patches[16 * kTiles * kMaxChannels], products[16 * kTiles * kMaxChannels];
    for (size_t x = 0; x < pixels; x += kTiles) {
        const size_t at = 2 * x * in_channels;
        const float *const from[4] = {rows[0] + at, rows[1] + at, rows[2] + at, rows[3] + at};
        (in_channels % Wide::count == 0 ? winograd_in<Wide> : winograd_in<Eight>)(from, in_channels, patches);
        multiply(patches, in_channels, weights, to.channels, products);
        (to.channels % Wide::count == 0 ? winograd_out<Wide> : winograd_out<Eight>)(products, to, x);
    }
}

// Calls work(four bordered rows of the input, coarse row) for each coarse row.
template <class Work> void each_coarse_row(const SameShape &shape, const float *in, Work work) noexcept {
    const size_t in_row = row_of(shape.cols, shape.in_channels);
    for (size_t y = 0; y < shape.rows / 2; y++) {
        const float *first = in + 2 * y * in_row;
        const float *const rows[4] = {first, first + in_row, first + 2 * in_row, first + 3 * in_row};
        work(rows, y);
    }
}

void same_direct(const SameShape &shape, const float *in, const float *weights, const float *bias,
                 float *out) noexcept {
    const size_t in_row = row_of(shape.cols, shape.in_channels), out_row = row_of(shape.cols, shape.channels);
    Row row = {};
    row.in_step = shape.in_channels;
    row.rows = 3;
    row.run = 3 * shape.in_channels;
    row.weights = weights;
    row.bias = bias;
    row.out_step = row.outputs = shape.channels;
    row.pixels = shape.cols;
    for (size_t y = 0; y < shape.rows; y++) {
        for (size_t t = 0; t < 3; t++)
            row.in[t] = in + (y + t) * in_row;
        row.out = out + (y + 1) * out_row + shape.channels;
        (shape.channels == 1 ? single : convolve<3>)(row);
    }
}

void same(const SameShape &shape, const float *in, const float *weights, const float *bias, float *out) noexcept {
    if (!shape.winograd())
        return same_direct(shape, in, weights, bias, out);
    const size_t out_row = row_of(shape.cols, shape.channels);
    each_coarse_row(shape, in, [&](const float *const(&rows)[4], size_t y) {
        float *first = out + (2 * y + 1) * out_row + shape.channels;
        winograd_rows(rows, shape.in_channels, weights, shape.cols / 2,
                      {bias, {first, first + out_row}, nullptr, nullptr, shape.channels});
    });
}

// Direct form for a single input channel: maxima of eight channels from four columns of two rows at a time.
void max_rows(const float *const (&rows)[4], const float *weights, size_t cols, const Output &to) noexcept {
    for (size_t first = 0; first < to.channels; first += Eight::count)
        for (size_t pixel = 0; pixel < cols; pixel += 4) {
            typename Eight::Vector sum[2][4] = {};
#pragma GCC unroll 3
            for (size_t t = 0; t < 3; t++)
#pragma GCC unroll 3
                for (size_t j = 0; j < 3; j++) {
                    const typename Eight::Vector weight = Eight::load(weights + (3 * t + j) * to.channels + first);
#pragma GCC unroll 8
                    for (size_t p = 0; p < 4; p++) {
                        sum[0][p] += weight * rows[t][pixel + p + j];
                        sum[1][p] += weight * rows[t + 1][pixel + p + j];
                    }
                }
            for (size_t p = 0; p < 4; p += 2) {
                typename Eight::Vector v[4] = {sum[0][p], sum[0][p + 1], sum[1][p], sum[1][p + 1]};
                store_block<Eight>(to, (pixel + p) / 2, first, v);
            }
        }
}

void same_max(const SameShape &shape, const float *in, const float *weights, const float *bias, float *pooled,
              Switch *switches) noexcept {
    const size_t cols = shape.cols / 2, channels = shape.channels;
    each_coarse_row(shape, in, [&](const float *const(&rows)[4], size_t y) {
        const Output to = {bias,
                           {nullptr, nullptr},
                           pooled + (y + 1) * row_of(cols, channels) + channels,
                           switches != nullptr ? switches + y * cols * channels : nullptr,
                           channels};
        if (shape.winograd())
            winograd_rows(rows, shape.in_channels, weights, cols, to);
        else
            max_rows(rows, weights, shape.cols, to);
    });
}

void weight_gradient(const SameShape &shape, const float *in, const float *out, float *packed) noexcept {
    for (size_t i = 0; i < 9 * shape.in_channels * shape.channels; i++)
        packed[i] = 0;
    const size_t in_row = row_of(shape.cols, shape.in_channels), out_row = row_of(shape.cols, shape.channels);
    Correlation c = {};
    c.in_step = shape.in_channels;
    c.run = 3 * shape.in_channels;
    c.outputs = shape.channels;
    c.pixels = shape.cols;
    c.gradient = packed;
    for (size_t y = 0; y < shape.rows; y++) {
        for (size_t t = 0; t < 3; t++)
            c.in[t] = in + (y + t) * in_row;
        c.out = out + (y + 1) * out_row + shape.channels;
        correlate(c);
    }
}

void unpool(const SameShape &shape, const float *pooled, const Switch *switches, float *out) noexcept {
    const size_t channels = shape.channels, out_row = row_of(shape.cols, channels);
    for (size_t y = 0; y < shape.rows / 2; y++)
        for (size_t q = 0; q < 2; q++)
            for (size_t x = 0; x < shape.cols / 2; x++) {
                const float *from = pooled + ((y + 1) * (shape.cols / 2 + 2) + x + 1) * channels;
                const Switch *chosen = switches + (y * shape.cols / 2 + x) * channels;
                float *to = out + (2 * y + q + 1) * out_row + (2 * x + 1) * channels;
                const Switch left = static_cast<Switch>(2 * q);
                for (size_t k = 0; k < channels; k += Eight::count) {
                    const typename Eight::Vector value = Eight::load(from + k), zero = {};
                    const typename Eight::Mask where = Eight::load(chosen + k);
                    Eight::store(to + k, where == left ? value : zero);
                    Eight::store(to + channels + k, where == left + 1 ? value : zero);
                }
            }
}

void pick(const SameShape &shape, const float *image, const Switch *switches, float *pooled) noexcept {
    const size_t channels = shape.channels, row = row_of(shape.cols, channels);
    for (size_t y = 0; y < shape.rows / 2; y++)
        for (size_t x = 0; x < shape.cols / 2; x++) {
            const float *upper = image + (2 * y + 1) * row + (2 * x + 1) * channels, *lower = upper + row;
            const Switch *chosen = switches + (y * shape.cols / 2 + x) * channels;
            float *to = pooled + ((y + 1) * (shape.cols / 2 + 2) + x + 1) * channels;
            for (size_t k = 0; k < channels; k += Eight::count) {
                const typename Eight::Mask where = Eight::load(chosen + k);
                const typename Eight::Vector top =
                    where == 0 ? Eight::load(upper + k) : Eight::load(upper + channels + k);
                const typename Eight::Vector bottom =
                    where == 2 ? Eight::load(lower + k) : Eight::load(lower + channels + k);
                Eight::store(to + k, where < 2 ? top : bottom);
            }
        }
}

} // namespace
} // namespace TOLIMAN_ISA

const SameConvKernels TOLIMAN_ISA_TABLE(same_conv) = {
    TOLIMAN_ISA::same, TOLIMAN_ISA::same_max, TOLIMAN_ISA::weight_gradient, TOLIMAN_ISA::unpool, TOLIMAN_ISA::pick};

} // namespace toliman::kernels
