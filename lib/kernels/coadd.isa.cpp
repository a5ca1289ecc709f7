// Method: a row has kCoaddLanes partial sums, lane i those of the columns i, i + kCoaddLanes, ... A vector of the
// instruction set holds some of the lanes: it passes over the row once per group of lanes, so that all ten sums stay in
// registers and every set adds in the same order. Products and the sums of a few rows are single precision, as a
// frame's own noise is 1e-2 to 1 of a pixel's counts; further sums are double. The last block of a row is copied, with
// weight 0 after the end.
#include "kernels/coadd.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

#if defined(__AVX512F__)
constexpr size_t kWidth = 16; // numbers of a vector
#elif defined(__AVX2__)
constexpr size_t kWidth = 8;
#else
constexpr size_t kWidth = 4;
#endif
constexpr size_t kMostAdded = 64; // numbers of a sum in single precision, if a row has no more
constexpr size_t kBand = 8;       // rows that are tested at once
typedef float Vector __attribute__((vector_size(4 * kWidth), aligned(4), may_alias));
typedef double Wide __attribute__((vector_size(8 * kWidth), aligned(8), may_alias));
typedef uint32_t Words __attribute__((vector_size(4 * kWidth), aligned(4), may_alias));
typedef int32_t Mask __attribute__((vector_size(4 * kWidth), aligned(4), may_alias));
typedef uint16_t Counts __attribute__((vector_size(2 * kWidth), aligned(2), may_alias));
typedef int16_t Slopes __attribute__((vector_size(2 * kWidth), aligned(2), may_alias));

inline Vector floats(const uint16_t *from) noexcept {
    return __builtin_convertvector(__builtin_convertvector(*reinterpret_cast<const Counts *>(from), Mask), Vector);
}
inline Vector floats(const int16_t *from) noexcept {
    return __builtin_convertvector(__builtin_convertvector(*reinterpret_cast<const Slopes *>(from), Mask), Vector);
}
inline Vector all(float value) noexcept {
    return value - Vector{};
}
inline Vector larger(Vector a, Vector b) noexcept {
    return a > b ? a : b;
}

// The pixels at row r and columns c to c + kWidth - 1, of which `whole` blocks are all inside the frame. Images are in
// units of the model's integers.
template <bool uniform, bool whole> class Block {
  public:
    Block(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, size_t r, size_t c) noexcept {
        const size_t i = r * frame.cols + c, inside = frame.cols - c, m = r * model.stride + c;
        light = floats(model.light + m);
        x = floats(model.slope_x + m);
        y = floats(model.slope_y + m);
        const uint16_t *const counts = frame.counts + r * frame.stride + c;
        if (whole) {
            n = floats(counts);
        } else {
            uint16_t copy[kWidth] = {};
            for (size_t k = 0; k < inside; k++)
                copy[k] = counts[k];
            n = floats(copy);
        }
        const auto read = [&](const float *from) {
            if (uniform)
                return all(*from);
            if (whole)
                return *reinterpret_cast<const Vector *>(from + i);
            Vector out = all(1);
            for (size_t k = 0; k < inside; k++)
                out[k] = from[i + k];
            return out;
        };
        gain = read(pixels.gain);
        offset = read(pixels.offset);
        spread = read(pixels.spread);
        added = read(pixels.added);
    }
    Vector light, x, y, n, gain, offset, spread, added;
};

// The sums of kWidth lanes of some rows.
struct Lanes {
    Vector sum[kCoaddSums] = {};

    template <bool uniform, bool whole>
    void add(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, float flux, size_t r,
             size_t c) noexcept {
        const Block<uniform, whole> at(frame, model, pixels, r, c);
        const Vector m = flux * at.light;
        Vector weight = 1 / (larger(m, all(pixels.least)) * at.spread + at.added);
        if (!whole)
            for (size_t k = frame.cols - c; k < kWidth; k++)
                weight[k] = 0;
        const Vector residual = (at.n * at.gain - at.offset) - m;
        const Vector wl = weight * at.light, wx = weight * at.x, wy = weight * at.y;
        sum[sum_ll] += wl * at.light;
        sum[sum_lx] += wl * at.x;
        sum[sum_ly] += wl * at.y;
        sum[sum_xx] += wx * at.x;
        sum[sum_xy] += wx * at.y;
        sum[sum_yy] += wy * at.y;
        sum[sum_lr] += wl * residual;
        sum[sum_xr] += wx * residual;
        sum[sum_yr] += wy * residual;
        sum[sum_rr] += weight * residual * residual;
    }
};

template <bool uniform>
void accumulate_of(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, float flux,
                   size_t start, size_t step, double *sums) noexcept {
    alignas(64) double lanes[kCoaddSums][kCoaddLanes] = {};
    const size_t group = frame.cols >= kMostAdded * kCoaddLanes ? step : step * (kMostAdded * kCoaddLanes / frame.cols);
    flux *= model.light_scale;
    for (size_t first = start; first < frame.rows; first += group)
        for (size_t lane = 0; lane < kCoaddLanes && lane < frame.cols; lane += kWidth) {
            Lanes some;
            for (size_t r = first; r < first + group && r < frame.rows; r += step) {
                size_t c = lane;
                for (; c + kWidth <= frame.cols; c += kCoaddLanes)
                    some.add<uniform, true>(frame, model, pixels, flux, r, c);
                if (c < frame.cols)
                    some.add<uniform, false>(frame, model, pixels, flux, r, c);
            }
            for (size_t s = 0; s < kCoaddSums; s++)
                *reinterpret_cast<Wide *>(&lanes[s][lane]) += __builtin_convertvector(some.sum[s], Wide);
        }
    for (size_t s = 0; s < kCoaddSums; s++) {
        sums[s] = 0;
        for (size_t i = 0; i < kCoaddLanes; i++)
            sums[s] += lanes[s][i];
    }
    const double light = static_cast<double>(model.light_scale), slope = static_cast<double>(model.slope_scale);
    const double scale[] = {light * light, light * slope, light * slope, slope * slope, slope * slope,
                            slope * slope, light,         slope,         slope,         1};
    for (size_t s = 0; s < kCoaddSums; s++)
        sums[s] *= scale[s];
}

void accumulate(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, float flux, size_t start,
                size_t step, double *sums) noexcept {
    (pixels.uniform ? accumulate_of<true> : accumulate_of<false>)(frame, model, pixels, flux, start, step, sums);
}

// The limits of test(), in units of the model's integers.
struct Limits {
    float light, x, y, square, most;
};

// Of the pixels of a block, what exceeds its limit: a pixel is left out if it is above 0. far: none saturates that is
// not far beyond the model.
template <bool uniform, bool far, bool whole>
__attribute__((always_inline)) inline Vector excess_of(const CoaddFrame &frame, const CoaddModel &model,
                                                       const CoaddPixels &pixels, const Limits &limits, size_t r,
                                                       size_t c) noexcept {
    const Block<uniform, whole> at(frame, model, pixels, r, c);
    const Vector m = larger(limits.light * at.light + limits.x * at.x + limits.y * at.y, all(pixels.least));
    const Vector residual = (at.n * at.gain - at.offset) - m, square = limits.square * at.spread;
    const Vector poisson = m + larger(residual, Vector{}) * (1.0f / 3);
    Vector excess = residual * residual - (square * poisson + limits.square * at.added);
    if (!far) {
        const Vector margin = pixels.limit * at.spread - m, size = larger(margin, -margin);
        excess = larger(larger(excess, at.n - limits.most), 25 * (m * at.spread + at.added) - margin * size);
    }
    return uniform ? excess : at.added < kCoaddUnused ? excess : Vector{};
}

template <bool uniform, bool far>
size_t test_of(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, const Limits &limits,
               uint32_t *found, size_t capacity) noexcept {
    const size_t whole = frame.cols / kWidth * kWidth;
    size_t count = 0;
    for (size_t first = 0; first < frame.rows; first += kBand) {
        const size_t end = frame.rows < first + kBand ? frame.rows : first + kBand;
        Vector band = {};
        for (size_t r = first; r < end; r++) {
            for (size_t c = 0; c < whole; c += kWidth)
                band = larger(band, excess_of<uniform, far, true>(frame, model, pixels, limits, r, c));
            if (whole < frame.cols)
                band = larger(band, excess_of<uniform, far, false>(frame, model, pixels, limits, r, whole));
        }
        bool any = false;
        for (size_t i = 0; i < kWidth; i++)
            any |= band[i] > 0;
        for (size_t r = first; any && r < end; r++)
            for (size_t c = 0; c < frame.cols; c += kWidth) {
                const Vector block = c < whole ? excess_of<uniform, far, true>(frame, model, pixels, limits, r, c)
                                               : excess_of<uniform, far, false>(frame, model, pixels, limits, r, c);
                for (size_t i = 0; i < kWidth && c + i < frame.cols; i++)
                    if (block[i] > 0 && count++ < capacity)
                        found[count - 1] = static_cast<uint32_t>(r * frame.cols + c + i);
            }
    }
    return count;
}

size_t test(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, const CoaddStep &step,
            float limit, uint32_t *found, size_t capacity) noexcept {
    const Limits limits = {step.flux * model.light_scale, step.x * model.slope_scale, step.y * model.slope_scale, limit,
                           static_cast<float>(pixels.most) - 0.5f};
    return (pixels.uniform ? pixels.far ? test_of<true, true> : test_of<true, false>
                           : test_of<false, false>)(frame, model, pixels, limits, found, capacity);
}

void add(const CoaddFrame &frame, uint32_t *sums) noexcept {
    for (size_t r = 0; r < frame.rows; r++) {
        const uint16_t *const counts = frame.counts + r * frame.stride;
        uint32_t *const sum = sums + r * frame.cols;
        for (size_t c = 0; c < frame.cols; c++)
            sum[c] += counts[c];
    }
}

// The first counts of a row are rarely 0.
size_t zero_rows(const CoaddFrame &frame) noexcept {
    size_t rows = 0;
    for (size_t r = 0; r < frame.rows; r++) {
        const uint16_t *const counts = frame.counts + r * frame.stride;
        size_t c = 0;
        while (c < frame.cols && counts[c] == 0)
            c++;
        rows += c == frame.cols ? 1 : 0;
    }
    return rows;
}

} // namespace
} // namespace TOLIMAN_ISA

const CoaddKernels TOLIMAN_ISA_TABLE(coadd) = {TOLIMAN_ISA::accumulate, TOLIMAN_ISA::test, TOLIMAN_ISA::add,
                                               TOLIMAN_ISA::zero_rows};

} // namespace toliman::kernels
