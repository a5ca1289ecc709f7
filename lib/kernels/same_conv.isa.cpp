#include "kernels/same_conv.hpp"

#include "kernels/conv_tile.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Floats from a bordered image's row to the next.
size_t row_of(size_t cols, size_t channels) noexcept {
    return (cols + 2) * channels;
}

// A single output channel: eight partial sums along the runs (multiples of 8 floats), halved three times.
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

void same(const SameShape &shape, const float *in, const float *weights, const float *bias, float *out) noexcept {
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
        (shape.channels == 1 ? single : convolve)(row);
    }
}

// Two rows of convolution and the maxima of their 2x2: what one coarse row takes.
struct Pool {
    const float *in[4];
    size_t in_step, run;
    const float *weights, *bias;
    float *pooled;
    Switch *switches; // or NULL
    size_t channels;
};

// The larger, and whose it was; the first of equals.
template <class Lanes> struct Best {
    typename Lanes::Vector value;
    typename Lanes::Mask from;
    static Best of(const Best &a, const Best &b) noexcept {
        const auto second = b.value > a.value;
        return {second ? b.value : a.value, second ? b.from : a.from};
    }
};

// Channels first ... first + M lanes of the coarse pixels that P fine columns from `pixel` on make.
template <class Lanes, size_t P, size_t M, size_t RUN>
void max_tile(const Pool &pool, size_t pixel, size_t first) noexcept {
    typename Lanes::Vector sum[2][P][M] = {};
    const size_t run = RUN != 0 ? RUN : pool.run;
    const float *weights = pool.weights + first;
    for (size_t t = 0; t < 3; t++) {
        const float *upper = pool.in[t] + pixel * pool.in_step, *lower = pool.in[t + 1] + pixel * pool.in_step;
        for (size_t j = 0; j < run; j++, upper++, lower++, weights += pool.channels) {
            typename Lanes::Vector weight[M];
#pragma GCC unroll 16
            for (size_t m = 0; m < M; m++)
                weight[m] = Lanes::load(weights + m * Lanes::count);
#pragma GCC unroll 16
            for (size_t p = 0; p < P; p++)
#pragma GCC unroll 16
                for (size_t m = 0; m < M; m++) {
                    sum[0][p][m] += weight[m] * upper[p * pool.in_step];
                    sum[1][p][m] += weight[m] * lower[p * pool.in_step];
                }
        }
    }
    const typename Lanes::Mask zero = {};
    for (size_t p = 0; p < P; p += 2)
        for (size_t m = 0; m < M; m++) {
            using B = Best<Lanes>;
            const B best = B::of(B::of(B{sum[0][p][m], zero}, B{sum[0][p + 1][m], zero + 1}),
                                 B::of(B{sum[1][p][m], zero + 2}, B{sum[1][p + 1][m], zero + 3}));
            const size_t channel = first + m * Lanes::count, at = (pixel + p) / 2 * pool.channels + channel;
            Lanes::store(pool.pooled + at, best.value + Lanes::load(pool.bias + channel));
            if (pool.switches != nullptr)
                Lanes::store(pool.switches + at, best.from);
        }
}

template <class Lanes, size_t P, size_t M, size_t RUN = 0> void max_tiles(const Pool &pool, size_t cols) noexcept {
    for (size_t first = 0; first < pool.channels; first += M * Lanes::count)
        for (size_t pixel = 0; pixel < cols; pixel += P)
            max_tile<Lanes, P, M, RUN>(pool, pixel, first);
}

void max_row(const Pool &pool, size_t cols) noexcept {
    if (pool.run == 3)
        return max_tiles<Eight, kPixels, 1, 3>(pool, cols);
    if (pool.channels % (2 * Wide::count) == 0)
        return max_tiles<Wide, kPixels / 2, 2>(pool, cols);
    if (pool.channels % Wide::count == 0)
        return max_tiles<Wide, kPixels, 1>(pool, cols);
    max_tiles<Eight, kPixels, 1>(pool, cols);
}

void same_max(const SameShape &shape, const float *in, const float *weights, const float *bias, float *pooled,
              Switch *switches) noexcept {
    const size_t in_row = row_of(shape.cols, shape.in_channels), out_row = row_of(shape.cols / 2, shape.channels);
    Pool pool = {};
    pool.in_step = shape.in_channels;
    pool.run = 3 * shape.in_channels;
    pool.weights = weights;
    pool.bias = bias;
    pool.channels = shape.channels;
    for (size_t y = 0; y < shape.rows / 2; y++) {
        for (size_t t = 0; t < 4; t++)
            pool.in[t] = in + (2 * y + t) * in_row;
        pool.pooled = pooled + (y + 1) * out_row + shape.channels;
        pool.switches = switches != nullptr ? switches + y * shape.cols / 2 * shape.channels : nullptr;
        max_row(pool, shape.cols);
    }
}

void weight_gradient(const SameShape &shape, const float *in, const float *out, float *packed) noexcept {
    for (size_t i = 0; i < shape.packed(); i++)
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
