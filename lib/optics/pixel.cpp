// Method: an image has no spatial frequency above f_c = D p/lambda_min cycles per pixel, so that a pixel's transfer
// function matters for |f| <= f_c only. The integral over a square pixel and a Gaussian blur of sigma s multiply the
// spectrum, along each axis, by
//     H(f) = sinc(f) exp(-2 pi^2 s^2 f^2),   sinc(f) = sin(pi f)/(pi f).
// The transfer function of a symmetric filter with taps 0 ... n - 1, from the middle outwards, is a polynomial of
// degree n - 1 in cos(2 pi f). Interpolating H at Chebyshev nodes of the band gives its coefficients; the error falls
// exponentially with n. Binning an oversampled image is avoided: its error is of second order in the sample spacing.
// Point sampling in place of the integral is wrong by 2.6e-2 (measured).
#include "optics/pixel.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

namespace toliman::optics {

namespace {

constexpr double kMaxCutoff = 0.4; // cycles per sample; filters stay short up to here
constexpr size_t kMaxTaps = 100;
constexpr double kSampleRounding = 1e-15; // relative to the peak
constexpr double kGiveUpRatio = 100;      // times the best error: longer filters only accumulate rounding
constexpr size_t kChecks = 1000;          // frequencies between 0 and the cutoff

// Chebyshev coefficients from values at the nodes cos(pi (j + 1/2) / n).
std::vector<double> coefficients_of(const std::vector<double> &values) {
    const size_t n = values.size();
    std::vector<double> result(n, 0.0);
    for (size_t k = 0; k < n; k++)
        for (size_t j = 0; j < n; j++)
            result[k] +=
                (k == 0 ? 1.0 : 2.0) / static_cast<double>(n) * values[j] *
                std::cos(kPi * static_cast<double>(k) * (static_cast<double>(j) + 0.5) / static_cast<double>(n));
    return result;
}

// Clenshaw's algorithm; x may be outside [-1, 1].
double chebyshev_sum(const std::vector<double> &coefficients, double x) noexcept {
    double next = 0, last = 0;
    for (size_t k = coefficients.size(); k-- > 1;) {
        const double sum = coefficients[k] + 2 * x * next - last;
        last = next;
        next = sum;
    }
    return coefficients[0] + x * next - last;
}

// H at a frequency in cycles per sample.
class TransferFunction {
  public:
    TransferFunction(bool integrated, double jitter, size_t oversampling)
        : integrated_(integrated), width_(static_cast<double>(oversampling)), jitter_(jitter * width_) {}

    double operator()(double frequency) const noexcept {
        const double phase = kPi * width_ * frequency, spread = kPi * jitter_ * frequency;
        const double box = integrated_ && phase != 0 ? std::sin(phase) / phase : 1;
        return box * std::exp(-2 * spread * spread);
    }

  private:
    bool integrated_;
    double width_, jitter_;
};

double frequency_of(double cosine) noexcept {
    return std::acos(std::clamp(cosine, -1.0, 1.0)) / (2 * kPi);
}

// With t = cos(2 pi f) the filter's transfer function is a polynomial in t: tap k is half the coefficient of the
// Chebyshev polynomial T_k(t) = cos(2 pi k f), tap 0 the whole of it. Interpolates H on the band, t in [cos(2 pi
// cutoff), 1], and re-expands the interpolant in T_k of t itself.
std::vector<double> taps_of(const TransferFunction &transfer, double cutoff, size_t count) {
    const double sine = std::sin(kPi * cutoff), reach = sine * sine, middle = 1 - reach;
    std::vector<double> values(count);
    const auto node = [&](size_t j) {
        return std::cos(kPi * (static_cast<double>(j) + 0.5) / static_cast<double>(count));
    };
    for (size_t j = 0; j < count; j++)
        values[j] = transfer(frequency_of(middle + reach * node(j)));
    const std::vector<double> inside = coefficients_of(values);
    for (size_t j = 0; j < count; j++)
        values[j] = chebyshev_sum(inside, (node(j) - middle) / reach);
    std::vector<double> taps = coefficients_of(values);
    for (size_t k = 1; k < count; k++)
        taps[k] /= 2; // one to each side
    return taps;
}

// Largest error of the transfer function inside the band, plus the rounding that long filters accumulate.
double error_of(const std::vector<double> &taps, const TransferFunction &transfer, double cutoff) {
    double worst = 0, size = 0;
    for (const double tap : taps)
        size += 2 * std::fabs(tap);
    for (size_t i = 0; i <= kChecks; i++) {
        const double frequency = cutoff * static_cast<double>(i) / kChecks;
        double sum = taps[0];
        for (size_t k = 1; k < taps.size(); k++)
            sum += 2 * taps[k] * std::cos(2 * kPi * static_cast<double>(k) * frequency);
        worst = std::max(worst, std::fabs(sum - transfer(frequency)));
    }
    return worst + kSampleRounding * size;
}

// out[i] = sum over k of taps[|k|] in[(i step + k) stride]
void filter_line(const double *in, size_t stride, size_t step, const std::vector<double> &taps, size_t count,
                 double *out, size_t out_stride) noexcept {
    for (size_t i = 0; i < count; i++) {
        const double *const middle = in + i * step * stride;
        double sum = taps[0] * middle[0];
        for (size_t k = 1; k < taps.size(); k++)
            sum += taps[k] * (*(middle - k * stride) + middle[k * stride]);
        out[i * out_stride] = sum;
    }
}

} // namespace

PixelFilter make_filter(double cutoff, bool integrated, double jitter_px, double accuracy) {
    PixelFilter filter;
    if (!integrated && jitter_px == 0)
        return filter;
    filter.oversampling = static_cast<size_t>(std::max(1.0, std::ceil(cutoff / kMaxCutoff)));
    const double fine = cutoff / static_cast<double>(filter.oversampling);
    const TransferFunction transfer(integrated, jitter_px, filter.oversampling);
    for (size_t count = 1; count <= kMaxTaps; count++) {
        std::vector<double> taps = taps_of(transfer, fine, count);
        // The filter is applied along both axes, so that the error counts twice.
        const double error = 2 * error_of(taps, transfer, fine);
        if (filter.empty() || error < filter.error) {
            filter.taps = std::move(taps);
            filter.error = error;
        }
        if (filter.error <= accuracy || !(error < kGiveUpRatio * filter.error))
            break;
    }
    return filter;
}

Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept {
    const auto samples = [&](size_t n) { return (n - 1) * filter.oversampling + 1 + 2 * filter.margin(); };
    return {samples(pixels.rows), samples(pixels.cols), pixels.pitch_rad / filter.oversampling};
}

Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter) {
    const Grid grid = sampling_grid(pixels, filter);
    const size_t margin = filter.margin(), step = filter.oversampling;
    Buffer<double> rows(grid.rows * pixels.cols), result(pixels.rows * pixels.cols);
    for (size_t row = 0; row < grid.rows; row++)
        filter_line(samples.data() + row * grid.cols + margin, 1, step, filter.taps, pixels.cols,
                    rows.data() + row * pixels.cols, 1);
    for (size_t col = 0; col < pixels.cols; col++)
        filter_line(rows.data() + margin * pixels.cols + col, pixels.cols, step, filter.taps, pixels.rows,
                    result.data() + col, pixels.cols);
    return result;
}

} // namespace toliman::optics
