// Method: interpolation by Lagrange polynomials through eight samples along each axis. The residual is white up to the
// Nyquist frequency, so that no interpolation is exact. Efficiency after a displacement by (1/6, 1/6) px, moving scene:
// 0.985 with 6, 8 or 12 samples, and with windows of the sinc function: the whitened derivative itself is not
// band-limited.
#include "bank/resample.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/shift.hpp"

namespace toliman::bank {

namespace {

constexpr size_t kTaps = 8;
constexpr long kBefore = 3; // samples before the one at or below the place

struct Weights {
    long first; // sample of the first weight, from the pixel
    double value[kernels::kShiftOrders][kernels::kMostTaps];
};

Weights weights_at(double displacement) noexcept {
    const double whole = std::floor(displacement), fraction = displacement - whole;
    Weights weights = {static_cast<long>(whole) - kBefore, {}};
    for (size_t t = 0; t < kTaps; t++) {
        double product = 1;
        for (size_t u = 0; u < kTaps; u++)
            if (u != t)
                product *= (fraction + static_cast<double>(kBefore) - static_cast<double>(u)) /
                           (static_cast<double>(t) - static_cast<double>(u));
        weights.value[0][t] = product;
    }
    return weights;
}

} // namespace

Resampler::Resampler(size_t cols) : padded_(cols + kTaps) {}

void Resampler::move(ImageView<const double> source, double x, double y, ImageView<double> result) noexcept {
    const kernels::ShiftKernels &kernel = kernels::shift_kernels();
    const Weights across = weights_at(x), down = weights_at(y);
    const auto source_rows = static_cast<long>(source.rows), source_cols = static_cast<long>(source.cols);
    const long needed = static_cast<long>(result.cols + kTaps) - 1; // samples of a line, from across.first on
    const long begin = std::clamp(-across.first, 0L, needed),
               end = std::clamp(source_cols - across.first, begin, needed); // those inside the source
    std::fill(padded_.begin(), padded_.end(), 0.0);
    constexpr size_t neighbours[kTaps] = {0, 1, 2, 3, 4, 5, 6, 7};
    for (size_t r = 0; r < result.rows; r++) {
        size_t rows[kTaps], taps = 0;
        double weights[kernels::kMostTaps];
        for (size_t t = 0; t < kTaps; t++) {
            const long row = static_cast<long>(r + t) + down.first;
            if (row < 0 || row >= source_rows)
                continue;
            rows[taps] = static_cast<size_t>(row) * source.stride;
            weights[taps++] = down.value[0][t];
        }
        double *const out[] = {result.row(r)};
        if (taps == 0 || begin == end) {
            std::fill_n(out[0], result.cols, 0.0);
            continue;
        }
        double *const inside[] = {padded_.data() + begin};
        kernel.sum(source.data + (across.first + begin), rows, weights, 1, taps, static_cast<size_t>(end - begin),
                   inside);
        kernel.sum(padded_.data(), neighbours, across.value[0], 1, kTaps, result.cols, out);
    }
}

} // namespace toliman::bank
