// Least squares of one sinusoid on the samples themselves. Everything is formed from residuals in long double, so that
// a fit that is good to the last bit of its data still has a residual with digits.
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "period/peak.hpp"
#include "period/power.hpp"
#include "period/sampling.hpp"

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

struct Wave {
    Real cosine, sine;
};

struct Fit {
    Real frequency;
    Real offset, cosine, sine;
    Real residual; // weighted sum of squares
    int rank;      // of cosine and sine: 1 where they coincide at every sample, as at the Nyquist frequency
};

constexpr double kCannotTell = std::numeric_limits<double>::infinity();

// 2 pi f t, reduced modulo one cycle while the product still has all its digits.
Real phase_of(Real frequency, Real t) noexcept {
    const auto f = static_cast<double>(frequency), u = static_cast<double>(t);
    const double product = f * u, error = std::fma(f, u, -product);
    const Real rest = (frequency - f) * t + static_cast<Real>(f) * (t - u);
    return kTwoPi * (static_cast<Real>(product - std::nearbyint(product)) + (static_cast<Real>(error) + rest));
}

// Solves a symmetric positive definite system by elimination; false if a pivot is nothing beside its diagonal.
bool solve(Matrix a, Vector b, Vector &x) noexcept {
    const Matrix whole = a;
    for (size_t i = 0; i < kParameters; i++) {
        if (!(a[i][i] > kCoincident * whole[i][i]))
            return false;
        for (size_t r = i + 1; r < kParameters; r++) {
            const Real factor = a[r][i] / a[i][i];
            for (size_t c = i; c < kParameters; c++)
                a[r][c] -= factor * a[i][c];
            b[r] -= factor * b[i];
        }
    }
    for (size_t i = kParameters; i-- > 0;) {
        Real sum = b[i];
        for (size_t c = i + 1; c < kParameters; c++)
            sum -= a[i][c] * x[c];
        x[i] = sum / a[i][i];
    }
    return true;
}

class Sinusoid {
  public:
    Sinusoid(const Samples &samples, bool fixed_mean);

    // Least squares at one frequency; what cosine and sine cannot tell apart is left out, as in the power.
    Fit at(Real frequency);
    // Gauss-Newton from a fit, within [low, high] in frequency and never uphill.
    Fit refine(Fit best, Real low, Real high);
    // Standard errors of frequency and amplitude from the normal matrix, scaled by the residual; +infinity where the
    // samples cannot tell.
    void errors(const Fit &fit, Peak &peak);
    // Frequency distance from the peak, on the side of the first step, where the power has fallen to half; 0 if not
    // within `far`. Steps grow up to `longest`, and again beyond 25 of these.
    Real half_power(const Fit &fit, Real step, Real longest, Real far);

    Real total() const noexcept { return total_; }
    Real mean_time() const noexcept { return mean_time_; }
    Real mean() const noexcept { return mean_; }

  private:
    // Cosines and sines at this frequency into waves_: nearly all of the time goes there.
    void turn(Real frequency);
    // Normal equations of (offset, cosine, sine, frequency) at a fit, the right side from its residuals.
    void normal(const Fit &fit, Matrix &matrix, Vector &right);
    // Weighted means of cosine and sine, which a fixed mean leaves as they are.
    Wave centre() const;
    // Adds the least-squares solution for what the fit leaves, and forms its residual.
    void improve(Fit &fit, const Wave &mean) const;

    std::vector<Point> points_;
    std::vector<Wave> waves_;
    Real turned_ = -1; // the frequency of waves_
    Real mean_time_ = 0, mean_ = 0, total_ = 0;
    size_t first_; // first free parameter: 0 with a floating mean, 1 without
};

Sinusoid::Sinusoid(const Samples &samples, bool fixed_mean)
    : points_(samples.count), waves_(samples.count), first_(fixed_mean ? 1 : 0) {
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

void Sinusoid::turn(Real frequency) {
    if (frequency == turned_)
        return;
    for (size_t i = 0; i < points_.size(); i++) {
        const Real phase = phase_of(frequency, points_[i].t);
        waves_[i] = {std::cos(phase), std::sin(phase)};
    }
    turned_ = frequency;
}

void Sinusoid::normal(const Fit &fit, Matrix &matrix, Vector &right) {
    matrix = {};
    right = {};
    turn(fit.frequency);
    for (size_t k = 0; k < points_.size(); k++) {
        const Point &point = points_[k];
        const auto [c, s] = waves_[k];
        const Vector row = {1, c, s, kTwoPi * point.t * (fit.sine * c - fit.cosine * s)};
        const Real model = fit.offset + fit.cosine * c + fit.sine * s;
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

Wave Sinusoid::centre() const {
    Wave mean = {0, 0};
    for (size_t i = 0; i < points_.size() && first_ == 0; i++) {
        mean.cosine += points_[i].w * waves_[i].cosine;
        mean.sine += points_[i].w * waves_[i].sine;
    }
    return mean;
}

void Sinusoid::improve(Fit &fit, const Wave &middle) const {
    Moments<Real> m = {};
    Real mean = 0;
    fit.residual = 0;
    for (size_t i = 0; i < points_.size(); i++) {
        const Point &point = points_[i];
        const Wave &wave = waves_[i];
        const Real c = wave.cosine - middle.cosine, s = wave.sine - middle.sine;
        const Real gap = point.y - (fit.offset + fit.cosine * wave.cosine + fit.sine * wave.sine);
        fit.residual += point.w * gap * gap;
        mean += point.w * gap;
        m.cc += point.w * c * c;
        m.cs += point.w * c * s;
        m.ss += point.w * s * s;
        m.yc += point.w * gap * c;
        m.ys += point.w * gap * s;
    }
    m.determinant = m.cc * m.ss - m.cs * m.cs;
    // Phases and means are rounded to 2^-60 or so: less than that is no direction.
    const Solved solved = period::solve(m, 1e-34L + kCoincident * (m.cc + m.ss));
    fit.rank = solved.rank;
    fit.cosine += solved.cosine;
    fit.sine += solved.sine;
    if (first_ == 0)
        fit.offset += mean - solved.cosine * middle.cosine - solved.sine * middle.sine;
}

Fit Sinusoid::at(Real frequency) {
    turn(frequency);
    const Wave middle = centre();
    Fit fit = {frequency, 0, 0, 0, total_, 0};
    improve(fit, middle);
    improve(fit, middle); // removes the rounding of the first
    Fit last = fit;
    improve(last, middle); // forms the residual of what stands in fit
    fit.residual = last.residual;
    return fit;
}

Fit Sinusoid::refine(Fit best, Real low, Real high) {
    constexpr int max_steps = 60;
    Matrix matrix;
    Vector right, step = {};
    Real shorten = 1;
    for (int i = 0; i < max_steps && shorten > 1e-6L; i++) {
        normal(best, matrix, right);
        if (!solve(matrix, right, step))
            break;
        const Fit fit = at(std::fmin(high, std::fmax(low, best.frequency + shorten * step[3])));
        if (fit.residual < best.residual) {
            best = fit;
            shorten = std::fmin(1.0L, 2 * shorten);
        } else {
            shorten /= 4;
        }
    }
    return best;
}

void Sinusoid::errors(const Fit &fit, Peak &peak) {
    peak.frequency_error = peak.amplitude_error = kCannotTell;
    const Real amplitude = std::hypot(fit.cosine, fit.sine);
    const auto parameters = static_cast<Real>((fit.rank == 2 ? kParameters : 2) - first_);
    const Real freedom = static_cast<Real>(points_.size()) - parameters;
    if (!(freedom > 0 && amplitude > 0))
        return;
    const Real scale = fit.residual / freedom, c = fit.cosine / amplitude, s = fit.sine / amplitude;
    Matrix matrix;
    Vector right, column = {};
    normal(fit, matrix, right);
    if (fit.rank < 2) { // one wave of known shape: no frequency to tell
        const Real mean = c * matrix[0][1] + s * matrix[0][2];
        const Real square = c * c * matrix[1][1] + 2 * c * s * matrix[1][2] + s * s * matrix[2][2] - mean * mean;
        if (square > 0)
            peak.amplitude_error = static_cast<double>(std::sqrt(scale / square));
        return;
    }
    if (!solve(matrix, {0, 0, 0, 1}, column))
        return;
    peak.frequency_error = static_cast<double>(std::sqrt(std::fmax(0.0L, column[3] * scale)));
    if (solve(matrix, {0, c, s, 0}, column))
        peak.amplitude_error = static_cast<double>(std::sqrt(std::fmax(0.0L, (c * column[1] + s * column[2]) * scale)));
}

Real Sinusoid::half_power(const Fit &fit, Real step, Real longest, Real far) {
    const Real half = (1 - fit.residual / total_) / 2;
    const auto excess = [&](Real distance) { return 1 - at(fit.frequency + distance).residual / total_ - half; };
    if (fit.rank == 0)
        return 0;
    Real inside = 0, outside = step, above = half, below;
    while ((below = excess(outside)) > 0) {
        inside = outside;
        above = below;
        if (std::fabs(1.5L * step) <= longest || std::fabs(outside) > 25 * longest)
            step *= 1.5L;
        outside += step;
        if (std::fabs(outside) > far || fit.frequency + outside <= 0)
            return 0;
    }
    // Regula falsi that halves the value of an end which stays (Dowell and Jarratt 1971, BIT 11, 168, "Illinois").
    Real middle = inside;
    for (int i = 0, stays = 0; i < 40; i++) {
        middle = inside + (outside - inside) * above / (above - below);
        const Real value = excess(middle);
        if (std::fabs(value) <= 1e-9L * half)
            break;
        const int side = value > 0 ? 1 : -1;
        (side > 0 ? inside : outside) = middle;
        (side > 0 ? above : below) = value;
        if (side == stays)
            (side > 0 ? below : above) /= 2;
        stays = side;
    }
    return std::fabs(middle);
}

} // namespace

void check_pushed(const Stream &stream, const Samples &samples) {
    if (static_cast<int64_t>(samples.count) != stream.totals().count)
        fail(Status::argument, "{n} = %zu samples, but %lld were pushed", samples.count,
             static_cast<long long>(stream.totals().count));
    for (size_t i = 0; i < samples.count; i++)
        stream.check(stream.sample(samples.t[i], 0, samples.y[i],
                                   samples.sigma != nullptr ? samples.sigma[i] : stream.grid().sigma_floor),
                     static_cast<int64_t>(i));
}

Peak fit_peak(const Stream &stream, const Samples &samples) {
    Peak peak = find_peak(stream);
    check_pushed(stream, samples);
    Sinusoid sinusoid(samples, stream.grid().fixed_mean);
    const Fit parabola = sinusoid.at(peak.frequency), grid = sinusoid.at(peak.grid_frequency);
    // One step either side of the parabola, but not out of the grid: there are powers that were never compared.
    const Fit start = parabola.residual < grid.residual ? parabola : grid;
    const Real step = stream.grid().df, first = stream.grid().f0, last = stream.grid().last();
    const Fit fit =
        sinusoid.refine(start, std::fmax(first, start.frequency - step), std::fmin(last, start.frequency + step));
    peak.at_edge = fit.frequency <= first || fit.frequency >= last;
    const Real ratio = fit.rank > 0 ? std::fmin(1.0L, fit.residual / sinusoid.total()) : 1;
    peak.frequency = static_cast<double>(fit.frequency);
    peak.power = static_cast<double>(1 - ratio);
    peak.log10_residual = static_cast<double>(std::log10(std::fmax(ratio, kLeastRatio)));
    // A peak of a time span T is 0.6/T wide on each side; closer steps do not miss what is narrower.
    const Real unit = 1 / static_cast<Real>(cadence_of(stream).span), longest = 0.2L * unit;
    const Real first_step = std::fmin(step, longest), far = std::fmax(5 * unit, 20 * step);
    const Real left = sinusoid.half_power(fit, -first_step, longest, far);
    const Real right = sinusoid.half_power(fit, first_step, longest, far);
    peak.fwhm = left > 0 && right > 0 ? static_cast<double>(left + right) : kCannotTell;
    sinusoid.errors(fit, peak);
    // From cosine and sine about the mean time to a sine about time_offset.
    const Real turn = phase_of(fit.frequency, static_cast<Real>(stream.grid().time_offset) - sinusoid.mean_time());
    const Real phase = std::atan2(fit.cosine, fit.sine) + turn;
    peak.phase = static_cast<double>(std::remainder(phase, kTwoPi));
    peak.amplitude = static_cast<double>(std::hypot(fit.cosine, fit.sine));
    peak.offset = static_cast<double>(fit.offset + sinusoid.mean());
    return peak;
}

} // namespace toliman::period
