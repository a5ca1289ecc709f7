// Least squares of one sinusoid on the samples themselves. Everything is formed from residuals in long double, so that
// a fit that is good to the last bit of its data still has a residual with digits.
#include <array>
#include <cmath>
#include <vector>

#include "period/peak.hpp"

namespace toliman::period {

namespace {

using Real = long double;
constexpr Real kTwoPi = 6.283185307179586476925286766559L;
constexpr size_t kParameters = 4; // offset, cosine, sine, frequency
using Vector = std::array<Real, kParameters>;
using Matrix = std::array<Vector, kParameters>;

struct Point {
    Real t, y, w; // about the weighted means; weights sum to 1
};

struct Fit {
    Real frequency;
    Vector coefficients; // offset, cosine, sine; the last unused
    Real residual;       // weighted sum of squares
};

// 2 pi f t, reduced modulo one cycle while the product still has all its digits.
Real phase_of(Real frequency, Real t) noexcept {
    const auto f = static_cast<double>(frequency), u = static_cast<double>(t);
    const double product = f * u, error = std::fma(f, u, -product);
    const Real rest = (frequency - f) * t + static_cast<Real>(f) * (t - u);
    return kTwoPi * (static_cast<Real>(product - std::nearbyint(product)) + (static_cast<Real>(error) + rest));
}

// Solves a symmetric positive definite system in place by elimination; false if it is singular.
bool solve(Matrix a, Vector b, size_t n, Vector &x) noexcept {
    for (size_t i = 0; i < n; i++) {
        if (!(a[i][i] > 0))
            return false;
        for (size_t r = i + 1; r < n; r++) {
            const Real factor = a[r][i] / a[i][i];
            for (size_t c = i; c < n; c++)
                a[r][c] -= factor * a[i][c];
            b[r] -= factor * b[i];
        }
    }
    for (size_t i = n; i-- > 0;) {
        Real sum = b[i];
        for (size_t c = i + 1; c < n; c++)
            sum -= a[i][c] * x[c];
        x[i] = sum / a[i][i];
    }
    return true;
}

class Sinusoid {
  public:
    Sinusoid(const Samples &samples, bool fixed_mean);

    Fit at(Real frequency) const;
    // Gauss-Newton from f, never leaving [f - reach, f + reach] and never uphill.
    Fit refine(Real frequency, Real reach) const;
    // Standard errors of frequency and amplitude from the normal matrix, scaled by the residual.
    void errors(const Fit &fit, Peak &peak) const;
    // Frequency distance from the peak on one side where the power has fallen to half, 0 if not within `far`.
    Real half_power(const Fit &fit, Real step, Real far) const;

    Real total() const noexcept { return total_; }
    Real mean_time() const noexcept { return mean_time_; }
    Real mean() const noexcept { return mean_; }

  private:
    // Normal equations of (offset, cosine, sine, frequency) at a fit, the right side from its residuals.
    void normal(const Fit &fit, Matrix &matrix, Vector &right) const;
    Real residual(Fit &fit) const;

    std::vector<Point> points_;
    Real mean_time_ = 0, mean_ = 0, total_ = 0;
    size_t first_; // first free parameter: 0 with a floating mean, 1 without
};

Sinusoid::Sinusoid(const Samples &samples, bool fixed_mean) : points_(samples.count), first_(fixed_mean ? 1 : 0) {
    Real weight = 0;
    for (size_t i = 0; i < samples.count; i++) {
        const Real sigma = samples.sigma != nullptr ? samples.sigma[i] : 1.0L;
        points_[i].w = 1 / (sigma * sigma);
        weight += points_[i].w;
    }
    for (size_t i = 0; i < samples.count; i++) {
        points_[i].w /= weight;
        mean_time_ += points_[i].w * (samples.t[i] - static_cast<Real>(samples.t[0]));
        mean_ += points_[i].w * (samples.y[i] - static_cast<Real>(samples.y[0]));
    }
    // Times about a double near the mean, so that differences of long time stamps are exact.
    mean_time_ = static_cast<double>(mean_time_ + samples.t[0]);
    mean_ += samples.y[0];
    for (size_t i = 0; i < samples.count; i++) {
        points_[i].t = samples.t[i] - mean_time_;
        points_[i].y = samples.y[i] - mean_;
        total_ += points_[i].w * points_[i].y * points_[i].y;
    }
}

void Sinusoid::normal(const Fit &fit, Matrix &matrix, Vector &right) const {
    matrix = {};
    right = {};
    for (const Point &point : points_) {
        const Real phase = phase_of(fit.frequency, point.t), c = std::cos(phase), s = std::sin(phase);
        const Vector row = {1, c, s, kTwoPi * point.t * (fit.coefficients[2] * c - fit.coefficients[1] * s)};
        const Real model = fit.coefficients[0] + fit.coefficients[1] * c + fit.coefficients[2] * s;
        for (size_t i = 0; i < kParameters; i++) {
            right[i] += point.w * row[i] * (point.y - model);
            for (size_t j = 0; j < kParameters; j++)
                matrix[i][j] += point.w * row[i] * row[j];
        }
    }
    if (first_ == 1) { // the mean is fixed: its row becomes the identity
        for (size_t i = 0; i < kParameters; i++)
            matrix[0][i] = matrix[i][0] = 0;
        matrix[0][0] = 1;
        right[0] = 0;
    }
}

Real Sinusoid::residual(Fit &fit) const {
    fit.residual = 0;
    for (const Point &point : points_) {
        const Real phase = phase_of(fit.frequency, point.t);
        const Real gap = point.y - (fit.coefficients[0] + fit.coefficients[1] * std::cos(phase) +
                                    fit.coefficients[2] * std::sin(phase));
        fit.residual += point.w * gap * gap;
    }
    return fit.residual;
}

Fit Sinusoid::at(Real frequency) const {
    Fit fit = {frequency, {}, total_};
    Matrix matrix;
    Vector right, step = {};
    for (int pass = 0; pass < 2; pass++) { // the second pass removes the rounding of the first
        normal(fit, matrix, right);
        if (!solve(matrix, right, 3, step))
            return {frequency, {}, total_};
        for (size_t i = 0; i < 3; i++)
            fit.coefficients[i] += step[i];
    }
    residual(fit);
    return fit;
}

Fit Sinusoid::refine(Real frequency, Real reach) const {
    constexpr int max_steps = 60;
    const Real low = frequency - reach, high = frequency + reach;
    Fit best = at(frequency);
    Matrix matrix;
    Vector right, step = {};
    Real shorten = 1;
    for (int i = 0; i < max_steps && shorten > 1e-6L; i++) {
        normal(best, matrix, right);
        if (!solve(matrix, right, kParameters, step))
            break;
        const Real next = std::fmin(high, std::fmax(low, best.frequency + shorten * step[3]));
        const Fit fit = at(next);
        if (fit.residual < best.residual) {
            best = fit;
            shorten = std::fmin(1.0L, 2 * shorten);
        } else {
            shorten /= 4;
        }
    }
    return best;
}

void Sinusoid::errors(const Fit &fit, Peak &peak) const {
    Matrix matrix;
    Vector right;
    normal(fit, matrix, right);
    const auto count = static_cast<Real>(points_.size());
    const Real freedom = count - static_cast<Real>(kParameters - first_);
    const Real scale = freedom > 0 ? fit.residual / freedom : 0;
    const Real amplitude = std::hypot(fit.coefficients[1], fit.coefficients[2]);
    Vector column = {}, unit = {};
    unit[3] = 1;
    peak.frequency_error = peak.amplitude_error = NAN;
    if (freedom > 0 && solve(matrix, unit, kParameters, column))
        peak.frequency_error = static_cast<double>(std::sqrt(std::fmax(0.0L, column[3] * scale)));
    unit = {0, fit.coefficients[1] / amplitude, fit.coefficients[2] / amplitude, 0};
    if (freedom > 0 && amplitude > 0 && solve(matrix, unit, kParameters, column))
        peak.amplitude_error =
            static_cast<double>(std::sqrt(std::fmax(0.0L, (unit[1] * column[1] + unit[2] * column[2]) * scale)));
}

Real Sinusoid::half_power(const Fit &fit, Real step, Real far) const {
    const auto power = [&](Real frequency) { return 1 - at(frequency).residual / total_; };
    const Real half = power(fit.frequency) / 2;
    Real inside = 0, outside = step;
    while (power(fit.frequency + outside) > half) {
        inside = outside;
        outside += step;
        if (std::fabs(outside) > far || fit.frequency + outside <= 0)
            return 0;
    }
    for (int i = 0; i < 24; i++) {
        const Real middle = (inside + outside) / 2;
        (power(fit.frequency + middle) > half ? inside : outside) = middle;
    }
    return std::fabs(inside + outside) / 2;
}

} // namespace

Peak fit_peak(const Stream &stream, const Samples &samples) {
    Peak peak = find_peak(stream);
    if (static_cast<int64_t>(samples.count) != stream.totals().count)
        fail(Status::argument, "n = %zu samples, but %lld were pushed", samples.count,
             static_cast<long long>(stream.totals().count));
    for (size_t i = 0; i < samples.count; i++)
        stream.check(samples.t[i], samples.y[i],
                     samples.sigma != nullptr ? samples.sigma[i] : stream.grid().sigma_floor, static_cast<int64_t>(i));
    const Sinusoid sinusoid(samples, stream.grid().fixed_mean);
    const Fit fit = sinusoid.refine(peak.frequency, stream.grid().df);
    const Real ratio = fit.residual / sinusoid.total();
    peak.frequency = static_cast<double>(fit.frequency);
    peak.power = static_cast<double>(1 - ratio);
    peak.log10_residual = static_cast<double>(std::log10(ratio));
    const Real far = 1000 * static_cast<Real>(stream.grid().df);
    const Real left = sinusoid.half_power(fit, -stream.grid().df, far);
    const Real right = sinusoid.half_power(fit, stream.grid().df, far);
    peak.fwhm = left > 0 && right > 0 ? static_cast<double>(left + right) : NAN;
    sinusoid.errors(fit, peak);
    // From cosine and sine about the mean time to a sine about time_offset.
    const Real turn = phase_of(fit.frequency, static_cast<Real>(stream.grid().time_offset) - sinusoid.mean_time());
    const Real phase = std::atan2(fit.coefficients[1], fit.coefficients[2]) + turn;
    peak.phase = static_cast<double>(std::remainder(phase, kTwoPi));
    peak.amplitude = static_cast<double>(std::hypot(fit.coefficients[1], fit.coefficients[2]));
    peak.offset = static_cast<double>(fit.coefficients[0] + sinusoid.mean());
    return peak;
}

} // namespace toliman::period
