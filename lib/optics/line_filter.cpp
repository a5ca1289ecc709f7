// Method: the integral over a square pixel and a Gaussian blur of sigma s multiply the spectrum of an image by
//     H(f) = sinc(f) exp(-2 pi^2 s^2 f^2),   sinc(f) = sin(pi f)/(pi f),
// which matters inside the band of the image only. There are two filters for it.
// - Interpolation, for narrow blurs: the transfer function of a symmetric filter with taps 0 ... n - 1, from the middle
//   outwards, is a polynomial of degree n - 1 in cos(2 pi f). Interpolating H at Chebyshev nodes of the band gives its
//   coefficients; the error falls exponentially with n. Nothing bounds the polynomial outside the band: for a blur of 5
//   samples it grows to 1e8, and amplifies rounding.
// - Sampling, for wide blurs: the Gaussian itself, at the distances of the taps, which are positive and sum to 1. Its
//   transfer function has an alias of exp(-2 pi^2 s^2 (1 - f)^2), below 1e-10 from 1.4 samples (f_c = 0.2) or 1.8 (0.4)
//   on, and the error of the cut, at 3 to 9 sigma. In the terms of a covariance it is a Hermite function: with u = x/s,
//   he_m = He_m/sqrt(m!) and phi the normal density,
//       g_m(f) <-> (-1)^floor(m/2) (|q|/s^2)^(m/2) he_m(u) phi(u)/s.
//   It is convolved with an interpolated filter for pixel, path and window.
// Samples to be interpolated (kernels/shift.hpp) are divided by the transform G of the window in the same filters: H/G
// in place of H, with errors weighted by G, as the interpolation multiplies by it again.
#include "optics/line_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/constants.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kMaxTaps = 100;                 // of an interpolated filter, from the middle outwards
constexpr double kGiveUpRatio = 100;             // times the best error: longer filters only accumulate rounding
constexpr size_t kChecks = 1000;                 // frequencies between 0 and the cutoff
constexpr size_t kStride = 20;                   // of them, of a first look at a filter
constexpr double kWide = 1.4;                    // samples; interpolated filters of narrower blurs do not amplify
constexpr double kShare = 0.1;                   // of the accuracy, for the alias and for the pixel of a sampled filter
constexpr double kLoosest = 1e-2;                // accuracy for which a cut is chosen
constexpr double kWidestCut = 9, kCutStep = 0.5; // standard deviations
constexpr double kCutGain = 0.5;                 // of the error, at least, by which a wider cut is better

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

// Frequencies of the band at which filters are compared with a transfer function, which is evaluated once.
class PassBand {
  public:
    PassBand(const TransferFunction &transfer, double cutoff)
        : transfer_(&transfer), edge_weight_(transfer.weight(cutoff)) {
        for (size_t i = 0; i <= kChecks; i++) {
            const double frequency = cutoff * static_cast<double>(i) / kChecks;
            turn_x_[i] = std::cos(2 * kPi * frequency);
            turn_y_[i] = std::sin(2 * kPi * frequency);
            wanted_[i] = transfer(frequency);
            weight_[i] = transfer.weight(frequency);
        }
    }

    // The filter with these taps, its error with the rounding that long filters accumulate. A stride of frequencies
    // above 1 gives a lower bound of the error.
    template <size_t stride = 1> LineFilter checked(std::vector<double> taps) const {
        LineFilter line;
        for (size_t k = 0; k < taps.size(); k++)
            line.gain += (k == 0 ? 1 : 2) * taps[k] * taps[k];
        line.gain = std::sqrt(line.gain) * edge_weight_;
        line.error = 2 * (largest_error<stride>(taps) + kSampleRounding * line.gain);
        line.taps = std::move(taps);
        line.odd = transfer_->odd();
        return line;
    }

  private:
    using Values = std::array<double, kChecks + 1>;

    template <size_t stride> double largest_error(const std::vector<double> &taps) const noexcept {
        constexpr size_t count = kChecks / stride + 1;
        std::array<double, count> sum, x, y; // x + i y = exp(2 pi i k f)
        sum.fill(transfer_->odd() ? 0 : taps[0]);
        x.fill(1);
        y.fill(0);
        for (size_t k = 1; k < taps.size(); k++) {
            const std::array<double, count> &part = transfer_->odd() ? y : x;
            for (size_t i = 0; i < count; i++) {
                const double turn_x = turn_x_[i * stride], turn_y = turn_y_[i * stride];
                const double next = x[i] * turn_x - y[i] * turn_y;
                y[i] = x[i] * turn_y + y[i] * turn_x;
                x[i] = next;
                sum[i] += 2 * taps[k] * part[i];
            }
        }
        double largest = 0;
        for (size_t i = 0; i < count; i++)
            largest = std::max(largest, std::fabs(sum[i] - wanted_[i * stride]) * weight_[i * stride]);
        return largest;
    }

    const TransferFunction *transfer_;
    double edge_weight_;
    Values turn_x_, turn_y_, wanted_, weight_;
};

// The shortest interpolated filter within the accuracy; else the most accurate one. Only filters that may be within it
// are compared with the transfer function at all frequencies.
LineFilter interpolated(const TransferFunction &transfer, double cutoff, double accuracy) {
    const PassBand band(transfer, cutoff);
    LineFilter best;
    for (size_t count = transfer.odd() ? 2 : 1; count <= kMaxTaps; count++) {
        LineFilter line = band.checked<kStride>(transfer.odd() ? odd_taps(transfer, cutoff, count)
                                                               : even_taps(transfer, cutoff, count));
        if (line.error <= accuracy)
            line = band.checked(std::move(line.taps));
        if (line.error <= accuracy)
            return line;
        const double error = line.error;
        if (best.taps.empty() || error < best.error)
            best = std::move(line);
        if (!(error < kGiveUpRatio * best.error))
            break;
    }
    return band.checked(std::move(best.taps));
}

// The filter whose transfer function is the product of those of two filters; taps from the middle outwards. That of an
// odd filter is without its factor i, hence the sign of two of them.
std::vector<double> convolved(const std::vector<double> &first, bool odd, const LineFilter &second) {
    const auto reach = static_cast<ptrdiff_t>(first.size() - 1), more = static_cast<ptrdiff_t>(second.taps.size() - 1);
    std::vector<double> taps(first.size() + second.taps.size() - 1, 0.0);
    for (ptrdiff_t k = -reach; k <= reach; k++)
        for (ptrdiff_t j = -more; j <= more; j++) {
            const bool negative = ((odd && k < 0) != (second.odd && j < 0)) != (odd && second.odd);
            if (k + j >= 0)
                taps[static_cast<size_t>(k + j)] += (negative ? -1 : 1) * first[static_cast<size_t>(std::abs(k))] *
                                                    second.taps[static_cast<size_t>(std::abs(j))];
        }
    return taps;
}

// The Gaussian, or Hermite function, at the distances of the taps, cut where it is accurate enough, and convolved with
// pixel, path and window.
LineFilter sampled(const TransferFunction &transfer, double cutoff, double accuracy) {
    const LineFilter box = interpolated(transfer.without_jitter(), cutoff, kShare * accuracy);
    const PassBand band(transfer, cutoff);
    LineFilter best;
    const double least = std::sqrt(-2 * std::log(std::min(accuracy, kLoosest))) - kCutStep;
    for (double cut = std::min(least, kWidestCut); cut <= kWidestCut; cut += kCutStep) {
        const double width = cut + std::sqrt(static_cast<double>(transfer.order()));
        std::vector<double> kernel(static_cast<size_t>(std::ceil(width * transfer.jitter())) + 1);
        for (size_t k = 0; k < kernel.size(); k++)
            kernel[k] = transfer.kernel(static_cast<double>(k));
        LineFilter line = band.checked(convolved(kernel, transfer.has_odd_kernel(), box));
        const bool better = best.taps.empty() || line.error < kCutGain * best.error;
        if (better)
            best = std::move(line);
        if (!better || best.error <= accuracy)
            break;
    }
    return best;
}

} // namespace

TransferFunction::TransferFunction(const Blur &blur, double variance, size_t m, const LinePath &path,
                                   size_t oversampling)
    : blur_(&blur), path_(&path), finer_(static_cast<double>(oversampling)), width_(finer_ * blur.pixel),
      jitter_(std::sqrt(variance) * width_), step_(2 * kPi * std::sqrt(std::fabs(blur.jitter.xy)) * width_), m_(m) {
    for (size_t i = 2; i <= m; i++)
        log_factorial_ += std::log(static_cast<double>(i));
}

double TransferFunction::box(double frequency) const noexcept {
    const double phase = kPi * width_ * frequency;
    double moved = path_->nodes.empty() ? 1 : 0;
    for (const Path::Node &node : path_->nodes)
        moved += node.weight * (path_->odd ? std::sin(2 * phase * node.at) : std::cos(2 * phase * node.at));
    return (blur_->integrated && phase != 0 ? std::sin(phase) / phase : 1) * moved / weight(frequency);
}

double TransferFunction::gaussian(double frequency) const noexcept {
    const double spread = kPi * jitter_ * frequency;
    if (m_ == 0)
        return std::exp(-2 * spread * spread);
    if (frequency == 0)
        return 0;
    const double log_power = static_cast<double>(m_) * std::log(step_ * frequency) - 0.5 * log_factorial_;
    return std::exp(log_power - 2 * spread * spread);
}

// The powers of |q|/s^2 are multiplied in step by step: neither they nor he_m alone need be representable.
double TransferFunction::kernel(double distance) const noexcept {
    const double u = distance / jitter_, ratio = step_ / (2 * kPi * jitter_);
    double last = 0, now = std::exp(-u * u / 2) / std::sqrt(2 * kPi) / jitter_; // ratio^m he_m(u) phi(u)/s
    for (size_t m = 0; m < m_; m++) {
        const auto order = static_cast<double>(m);
        const double next = (u * ratio * now - std::sqrt(order) * ratio * ratio * last) / std::sqrt(order + 1);
        last = now;
        now = next;
    }
    return m_ / 2 % 2 == 1 ? -now : now;
}

double TransferFunction::weight(double frequency) const noexcept {
    return blur_->window.taps > 0 ? blur_->window.transform(finer_ * frequency) : 1;
}

double TransferFunction::largest(double cutoff) const noexcept {
    double largest = 0;
    for (size_t i = 0; i <= kChecks; i++) {
        const double frequency = cutoff * static_cast<double>(i) / kChecks;
        largest = std::max(largest, std::fabs((*this)(frequency)) * weight(frequency));
    }
    return largest;
}

TransferFunction TransferFunction::without_jitter() const noexcept {
    TransferFunction still = *this;
    still.jitter_ = still.log_factorial_ = 0;
    still.m_ = 0;
    return still;
}

LineFilter make_line(const TransferFunction &transfer, double cutoff, double accuracy) {
    const bool wide = transfer.jitter() >= kWide && transfer.gaussian(1 - cutoff) <= kShare * accuracy;
    return wide ? sampled(transfer, cutoff, accuracy) : interpolated(transfer, cutoff, accuracy);
}

} // namespace toliman::optics
