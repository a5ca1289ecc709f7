// Method: an image has no spatial frequency above f_c = D p/lambda_min cycles per pixel, so that a pixel's transfer
// function matters for |f| <= f_c only. The integral over a square pixel and a Gaussian blur of sigma s multiply the
// spectrum, along each axis, by
//     H(f) = sinc(f) exp(-2 pi^2 s^2 f^2),   sinc(f) = sin(pi f)/(pi f).
// The transfer function of a symmetric filter with taps 0 ... n - 1, from the middle outwards, is a polynomial of
// degree n - 1 in cos(2 pi f). Interpolating H at Chebyshev nodes of the band gives its coefficients; the error falls
// exponentially with n. Binning an oversampled image is avoided: its error is of second order in the sample spacing.
// Point sampling in place of the integral is wrong by 2.6e-2 (measured).
// A covariance q = xy of the jitter multiplies the spectrum by exp(-4 pi^2 q f_x f_y), which no product of two filters
// has. It is expanded in products (Mehler 1866),
//     H = sum over m of (-sign q)^m g_m(f_x) g_m(f_y),   g_m(f) = H_0(f) (2 pi sqrt|q| f)^m / sqrt(m!),
// each g_m a filter along its axis, antisymmetric for odd m. No term exceeds (q^2 / (xx yy))^(m/2), so nothing cancels;
// the terms end where their product is below the accuracy.
// Samples to be interpolated (kernels/shift.hpp) are divided by the transform G of the window in the same filters: H/G
// in place of H, with errors weighted by G, as the interpolation multiplies by it again.
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
constexpr size_t kMaxTerms = 256;         // of the expansion in the covariance
constexpr double kTermShare = 0.25;       // of the accuracy, for each filter of the expansion

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

// g_m at a frequency in cycles per sample, over that of the window; m = 0 is H.
class TransferFunction {
  public:
    TransferFunction(const Blur &blur, double variance, size_t m, size_t oversampling)
        : blur_(blur), finer_(static_cast<double>(oversampling)), width_(finer_ * blur.pixel),
          jitter_(std::sqrt(variance) * width_), step_(2 * kPi * std::sqrt(std::fabs(blur.jitter.xy)) * width_), m_(m) {
        for (size_t i = 2; i <= m; i++)
            log_factorial_ += std::log(static_cast<double>(i));
    }

    bool odd() const noexcept { return m_ % 2 == 1; }

    double operator()(double frequency) const noexcept {
        const double phase = kPi * width_ * frequency, spread = kPi * jitter_ * frequency;
        const double box = (blur_.integrated && phase != 0 ? std::sin(phase) / phase : 1) / weight(frequency);
        if (m_ == 0)
            return box * std::exp(-2 * spread * spread);
        if (frequency == 0)
            return 0;
        const double log_power = static_cast<double>(m_) * std::log(step_ * frequency) - 0.5 * log_factorial_;
        return box * std::exp(log_power - 2 * spread * spread);
    }

    // Of an error at this frequency.
    double weight(double frequency) const noexcept {
        return blur_.window.taps > 0 ? blur_.window.transform(finer_ * frequency) : 1;
    }

  private:
    const Blur &blur_;
    double finer_, width_, jitter_, step_; // width_ in samples, jitter_ in samples
    size_t m_;
    double log_factorial_ = 0;
};

double frequency_of(double cosine) noexcept {
    return std::acos(std::clamp(cosine, -1.0, 1.0)) / (2 * kPi);
}

// With t = cos(2 pi f) the filter's transfer function is a polynomial in t: tap k is half the coefficient of the
// Chebyshev polynomial T_k(t) = cos(2 pi k f), tap 0 the whole of it. Interpolates H on the band, t in [cos(2 pi
// cutoff), 1], and re-expands the interpolant in T_k of t itself.
template <class Transfer> std::vector<double> even_taps(const Transfer &transfer, double cutoff, size_t count) {
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

// An antisymmetric filter has the transfer function (times i) sin(2 pi f) times an even one with taps e_k: its taps are
// (e_(k-1) - e_(k+1)) / 2.
std::vector<double> odd_taps(const TransferFunction &transfer, double cutoff, size_t count) {
    const auto even = [&](double f) { return transfer(f) / std::sin(2 * kPi * f); };
    std::vector<double> e = even_taps(even, cutoff, count - 1), taps(count, 0.0);
    e.resize(count + 1, 0.0);
    for (size_t k = 1; k < count; k++)
        taps[k] = (e[k - 1] - e[k + 1]) / 2;
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
        for (size_t k = 1; k < taps.size(); k++) {
            const double angle = 2 * kPi * static_cast<double>(k) * frequency;
            sum += 2 * taps[k] * (transfer.odd() ? std::sin(angle) : std::cos(angle));
        }
        worst = std::max(worst, std::fabs(sum - transfer(frequency)) * transfer.weight(frequency));
    }
    return worst + kSampleRounding * size * transfer.weight(cutoff);
}

double largest_of(const TransferFunction &transfer, double cutoff) noexcept {
    double largest = 0;
    for (size_t i = 0; i <= kChecks; i++) {
        const double frequency = cutoff * static_cast<double>(i) / kChecks;
        largest = std::max(largest, std::fabs(transfer(frequency)) * transfer.weight(frequency));
    }
    return largest;
}

// The shortest filter found whose error, counted twice because a filter acts along both axes, is within the accuracy;
// else the most accurate one.
LineFilter make_line(const TransferFunction &transfer, double cutoff, double accuracy) {
    LineFilter line;
    line.odd = transfer.odd();
    for (size_t count = line.odd ? 2 : 1; count <= kMaxTaps; count++) {
        std::vector<double> taps = line.odd ? odd_taps(transfer, cutoff, count) : even_taps(transfer, cutoff, count);
        const double error = 2 * error_of(taps, transfer, cutoff);
        if (line.taps.empty() || error < line.error) {
            line.taps = std::move(taps);
            line.error = error;
        }
        if (line.error <= accuracy || !(error < kGiveUpRatio * line.error))
            break;
    }
    return line;
}

// out[i] = sum over k of taps[|k|] in[(i step + k) stride], with the sign of k for an odd filter; added to out unless
// it is the first.
void filter_line(const double *in, size_t stride, size_t step, const LineFilter &line, size_t count, double *out,
                 size_t out_stride, bool first = true) noexcept {
    const std::vector<double> &taps = line.taps;
    for (size_t i = 0; i < count; i++) {
        const double *const middle = in + i * step * stride;
        double sum = taps[0] * middle[0];
        if (line.odd)
            for (size_t k = 1; k < taps.size(); k++)
                sum += taps[k] * (middle[k * stride] - *(middle - k * stride));
        else
            for (size_t k = 1; k < taps.size(); k++)
                sum += taps[k] * (*(middle - k * stride) + middle[k * stride]);
        out[i * out_stride] = first ? sum : out[i * out_stride] + sum;
    }
}

// The adjoint of filter_line: adds in[i] times the taps to out.
void spread_line(const double *in, size_t stride, size_t step, const LineFilter &line, size_t count, double *out,
                 size_t out_stride) noexcept {
    const std::vector<double> &taps = line.taps;
    for (size_t i = 0; i < count; i++) {
        double *const middle = out + i * step * out_stride;
        const double value = in[i * stride];
        middle[0] += taps[0] * value;
        for (size_t k = 1; k < taps.size(); k++) {
            middle[k * out_stride] += taps[k] * value;
            *(middle - k * out_stride) += (line.odd ? -taps[k] : taps[k]) * value;
        }
    }
}

// Appends the terms m = 1, 2, ... of the expansion in the covariance, until they are within the accuracy.
void add_terms(double cutoff, const Blur &blur, double accuracy, PixelFilter &filter) {
    const Jitter &jitter = blur.jitter;
    double last = 1;
    for (size_t m = 1; m <= kMaxTerms; m++) {
        const TransferFunction x(blur, jitter.xx, m, filter.oversampling), y(blur, jitter.yy, m, filter.oversampling);
        const double size_x = largest_of(x, cutoff), size_y = largest_of(y, cutoff), size = size_x * size_y;
        if (size <= kTermShare * accuracy * (1 - size / last) || m == kMaxTerms) {
            filter.error += size / std::max(1 - size / last, 1.0 / kMaxTerms); // as a geometric series
            return;
        }
        last = size;
        filter.terms.push_back({make_line(x, cutoff, kTermShare * accuracy / std::max(size_y, 1.0)),
                                make_line(y, cutoff, kTermShare * accuracy / std::max(size_x, 1.0))});
        auto &[along_x, along_y] = filter.terms.back();
        filter.error += (along_x.error * size_y + along_y.error * size_x) / 2;
        if (m % 2 == 1 && jitter.xy < 0) // the product of two odd filters has the factor i^2 = -1
            for (double &tap : along_y.taps)
                tap = -tap;
    }
}

} // namespace

size_t PixelFilter::margin() const noexcept {
    size_t longest = 1;
    for (const auto &term : terms)
        longest = std::max({longest, term[0].taps.size(), term[1].taps.size()});
    return longest - 1;
}

size_t PixelFilter::taps() const noexcept {
    size_t sum = 0;
    for (const auto &term : terms)
        sum += term[0].taps.size() + term[1].taps.size();
    return sum;
}

PixelFilter make_filter(double cutoff, const Blur &blur, double accuracy) {
    PixelFilter filter;
    if (!blur.any())
        return filter;
    filter.oversampling = static_cast<size_t>(std::max(1.0, std::ceil(cutoff / kMaxCutoff)));
    const double fine = cutoff / static_cast<double>(filter.oversampling);
    const double share = blur.jitter.xy != 0 ? kTermShare * accuracy : accuracy;
    const auto line = [&](double variance) {
        return make_line(TransferFunction(blur, variance, 0, filter.oversampling), fine, share);
    };
    filter.terms.push_back({line(blur.jitter.xx), line(blur.jitter.yy)});
    filter.error = std::max(filter.terms[0][0].error, filter.terms[0][1].error);
    if (blur.jitter.xy != 0)
        add_terms(fine, blur, accuracy, filter);
    return filter;
}

Grid sampling_grid(const Grid &pixels, const PixelFilter &filter) noexcept {
    const auto samples = [&](size_t n) { return (n - 1) * filter.oversampling + 1 + 2 * filter.margin(); };
    Grid grid = pixels;
    grid.rows = samples(pixels.rows);
    grid.cols = samples(pixels.cols);
    grid.pitch_rad /= filter.oversampling;
    return grid;
}

Buffer<double> filtered(const Buffer<double> &samples, const Grid &pixels, const PixelFilter &filter) {
    const Grid grid = sampling_grid(pixels, filter);
    const size_t margin = filter.margin(), step = filter.oversampling;
    Buffer<double> rows(grid.rows * pixels.cols), result(pixels.rows * pixels.cols);
    for (const auto &[along_x, along_y] : filter.terms) {
        for (size_t row = 0; row < grid.rows; row++)
            filter_line(samples.data() + row * grid.cols + margin, 1, step, along_x, pixels.cols,
                        rows.data() + row * pixels.cols, 1);
        for (size_t col = 0; col < pixels.cols; col++)
            filter_line(rows.data() + margin * pixels.cols + col, pixels.cols, step, along_y, pixels.rows,
                        result.data() + col, pixels.cols, &along_x == &filter.terms[0][0]);
    }
    return result;
}

Buffer<double> spread(const Buffer<double> &weights, const Grid &pixels, const PixelFilter &filter) {
    const Grid grid = sampling_grid(pixels, filter);
    const size_t margin = filter.margin(), step = filter.oversampling;
    Buffer<double> samples(grid.rows * grid.cols);
    for (const auto &[along_x, along_y] : filter.terms) {
        Buffer<double> rows(grid.rows * pixels.cols);
        for (size_t col = 0; col < pixels.cols; col++)
            spread_line(weights.data() + col, pixels.cols, step, along_y, pixels.rows,
                        rows.data() + margin * pixels.cols + col, pixels.cols);
        for (size_t row = 0; row < grid.rows; row++)
            spread_line(rows.data() + row * pixels.cols, 1, step, along_x, pixels.cols,
                        samples.data() + row * grid.cols + margin, 1);
    }
    return samples;
}

} // namespace toliman::optics
