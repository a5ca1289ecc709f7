// Method: least squares of y = offset + a cos 2 pi f t + b sin 2 pi f t in all four parameters, on the samples
// themselves. Gauss-Newton steps in f; after each, offset, a and b are solved at the new f. A step that does not reduce
// the residual is shortened by 4, so that the fit is never worse than the highest grid point.
// Times and values are taken about their weighted means, and everything is formed from residuals in long double (64-bit
// mantissa), never as total - explained: 1 - power is correct down to 1e-31, where the sums resolve 1e-14.
// Steps end below 1e-9 of the standard error of f. Half-power points: from the power of the batch periodogram on a grid
// of 50 points per 1/(time span), interpolated by polynomials of degree 7 (error 1e-10 of the power), as an evaluation
// in long double takes as long as that whole grid.
// Standard errors: square roots of the diagonal of the inverse normal matrix, scaled by the residual per degree of
// freedom.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "base/robust.hpp"
#include "period/batch/batch.hpp"
#include "period/peak.hpp"
#include "period/sample_basis.hpp"
#include "period/sampling.hpp"
#include "period/stream/power.hpp"

namespace toliman::period {

namespace {

using Real = long double;
constexpr Real kTwoPi = 2 * kLongPi;
constexpr size_t kParameters = 4; // offset, cosine, sine, frequency
using Vector = std::array<Real, kParameters>;
using Matrix = std::array<Vector, kParameters>;

struct Point {
    Real t, y, w; // time and value about their weighted means; the weights sum to 1
};

struct Cis {
    Real cosine, sine;
};

struct Fit {
    Real frequency;
    Real offset, cosine, sine;
    Real residual; // weighted sum of squared residuals
    int rank;      // of cosine and sine: 1 where they coincide at every sample, as at the Nyquist frequency
};

constexpr double kUndetermined = std::numeric_limits<double>::infinity();

// f t, reduced modulo one cycle before the product is rounded: TwoProd by FMA, plus the parts of f and t below double.
Real cycles_of(Real frequency, Real t) noexcept {
    const auto f = static_cast<double>(frequency), u = static_cast<double>(t);
    const double product = f * u, error = std::fma(f, u, -product);
    const Real rest = (frequency - f) * t + static_cast<Real>(f) * (t - u);
    return static_cast<Real>(product - std::nearbyint(product)) + (static_cast<Real>(error) + rest);
}

// Of an angle within an eighth of a turn, as the reduction of others by libm takes longer than cosine and sine.
Cis cis_of(Real cycles) noexcept {
    const double quarter = std::nearbyint(4 * static_cast<double>(cycles));
    const Real angle = kTwoPi * (cycles - static_cast<Real>(quarter) / 4);
    const Real c = std::cos(angle), s = std::sin(angle);
    switch (static_cast<int>(quarter) & 3) {
    case 0:
        return {c, s};
    case 1:
        return {-s, c};
    case 2:
        return {-c, -s};
    default:
        return {s, -c};
    }
}

// Solves a symmetric positive definite system by elimination. Returns false if a pivot is negligible against its
// diagonal.
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
    Sinusoid(const Stream &stream, const Samples &samples);

    // Least squares at a fixed frequency. Directions in which cosine and sine coincide are not fitted, as in the power.
    Fit at(Real frequency);
    // Gauss-Newton from a fit, with the frequency in [low, high]. The residual never increases.
    Fit refine(Fit best, Real low, Real high);
    // Standard errors of frequency and amplitude from the normal matrix, scaled by the residual; +infinity if the
    // samples do not determine them.
    void errors(const Fit &fit, Peak &peak);
    // Goodness of a fit and number of outliers, with absolute sigmas. Priors count as observations.
    void judge(const Fit &fit, Peak &peak);
    Real total() const noexcept { return total_; }
    Real mean_time() const noexcept { return mean_time_; }
    // The offset of a fit, about 0: the fitted mean, with nuisance functions its coefficient with theirs.
    Real offset(const Fit &fit);

  private:
    // Computes cis_ at this frequency; this takes nearly all of the time.
    void set_frequency(Real frequency);
    // Normal equations of (offset, cosine, sine, frequency) at a fit, with the right-hand side from its residuals.
    void normal(const Fit &fit, Matrix &matrix, Vector &right);
    // The derivative of the model by the frequency at each sample.
    std::vector<Real> derivative(const Fit &fit) const;
    // Removes the nuisance functions from the values, and adds rows for their priors.
    void add_basis(const Stream &stream, const Samples &samples, Real weight);
    void project_cis();
    // Weighted means of cosine and sine; 0 with a fixed mean.
    Cis mean_cis() const;
    // Whether a step would reduce the residual by less than the 1e-18 part of its mean square: by 1e-9 of the errors.
    bool is_negligible(const Vector &step, const Vector &right, const Fit &fit) const noexcept;
    // Adds the least-squares solution for the residuals of a fit to it. moments: those of cosine and sine are given.
    void add_correction(Fit &fit, const Cis &cis_mean, Moments<Real> moments) const;
    Moments<Real> cis_moments(const Cis &cis_mean) const noexcept;
    Real gap(const Fit &fit, size_t i) const noexcept {
        return points_[i].y - (fit.offset + fit.cosine * cis_[i].cosine + fit.sine * cis_[i].sine);
    }
    Real freedom(const Fit &fit) const noexcept {
        const auto parameters = static_cast<Real>((fit.rank == 2 ? kParameters : 2) - first_);
        return static_cast<Real>(points_.size()) - parameters - static_cast<Real>(basis_ ? basis_->used() : 0);
    }

    std::vector<Point> points_;
    std::vector<Cis> cis_; // cosine and sine of each sample's phase
    Real frequency_ = -1;  // of cis_
    Real mean_time_ = 0, mean_ = 0, total_ = 0;
    Real weight_ = 0; // sum of the weights of the samples before they were scaled
    size_t first_;    // first free parameter: 0 with a floating mean, 1 without
    // With nuisance functions, cis_ and values are what remains after projecting the functions and the mean out.
    std::optional<SampleBasis> basis_;
    size_t samples_; // the rows after them are those of the priors
    std::vector<Cis> whole_cis_;
    std::vector<Real> whole_values_;
};

Sinusoid::Sinusoid(const Stream &stream, const Samples &samples)
    : points_(samples.count), cis_(samples.count), first_(stream.grid().fixed_mean ? 1 : 0), samples_(samples.count) {
    Real weight = 0;
    for (size_t i = 0; i < samples.count; i++) {
        const Real sigma = samples.sigma != nullptr ? samples.sigma[i] : 1.0L;
        points_[i].w = 1 / (sigma * sigma);
        weight += points_[i].w;
    }
    weight_ = weight;
    for (size_t i = 0; i < samples.count; i++) {
        points_[i].w /= weight;
        mean_time_ += points_[i].w * (samples.t[i] - static_cast<Real>(samples.t[0]));
        mean_ += points_[i].w * (samples.y[i] - static_cast<Real>(samples.y[0]));
    }
    // Times about a double near the mean, so that differences of large time stamps are exact.
    mean_time_ = static_cast<double>(mean_time_ + samples.t[0]);
    mean_ += samples.y[0];
    for (size_t i = 0; i < samples.count; i++) {
        points_[i].t = samples.t[i] - mean_time_;
        points_[i].y = samples.y[i] - mean_;
        total_ += points_[i].w * points_[i].y * points_[i].y;
    }
    if (stream.grid().basis.any())
        add_basis(stream, samples, weight);
}

void Sinusoid::add_basis(const Stream &stream, const Samples &samples, Real weight) {
    std::vector<Real> weights;
    for (const Point &point : points_)
        weights.push_back(point.w);
    // Without sigmas, those of the samples are sigma_floor, not 1.
    const Real floor = samples.sigma != nullptr ? 1 : stream.grid().sigma_floor;
    basis_.emplace(stream, samples, weights, floor * floor / weight);
    whole_values_ = basis_->values(samples, mean_);
    std::vector<Real> values = whole_values_;
    basis_->project(values);
    points_.resize(basis_->rows());
    cis_.resize(basis_->rows());
    total_ = 0;
    for (size_t i = 0; i < points_.size(); i++) {
        points_[i].w = basis_->weight(i);
        points_[i].y = values[i];
        total_ += points_[i].w * values[i] * values[i];
    }
    first_ = 1; // the mean is one of the functions
}

void Sinusoid::project_cis() {
    whole_cis_ = cis_;
    std::vector<Real> cosine, sine;
    for (const Cis &wave : cis_) {
        cosine.push_back(wave.cosine);
        sine.push_back(wave.sine);
    }
    basis_->project(cosine);
    basis_->project(sine);
    for (size_t i = 0; i < cis_.size(); i++)
        cis_[i] = {cosine[i], sine[i]};
}

Real Sinusoid::offset(const Fit &fit) {
    if (!basis_)
        return fit.offset + mean_;
    set_frequency(fit.frequency);
    std::vector<Real> rest = whole_values_;
    for (size_t i = 0; i < rest.size(); i++)
        rest[i] -= fit.cosine * whole_cis_[i].cosine + fit.sine * whole_cis_[i].sine;
    return basis_->mean_coefficient(rest) + mean_;
}

void Sinusoid::set_frequency(Real frequency) {
    if (frequency == frequency_)
        return;
    for (size_t i = 0; i < points_.size(); i++)
        cis_[i] = cis_of(cycles_of(frequency, points_[i].t));
    if (basis_) {
        std::fill(cis_.begin() + static_cast<std::ptrdiff_t>(samples_), cis_.end(), Cis{0, 0});
        project_cis();
    }
    frequency_ = frequency;
}

// d/df (a cos 2 pi f t + b sin 2 pi f t) = 2 pi t (b cos - a sin), without what the functions describe of it.
std::vector<Real> Sinusoid::derivative(const Fit &fit) const {
    const std::vector<Cis> &waves = basis_ ? whole_cis_ : cis_;
    std::vector<Real> rows(points_.size());
    for (size_t i = 0; i < rows.size(); i++)
        rows[i] = kTwoPi * points_[i].t * (fit.sine * waves[i].cosine - fit.cosine * waves[i].sine);
    if (basis_)
        basis_->project(rows);
    return rows;
}

void Sinusoid::normal(const Fit &fit, Matrix &matrix, Vector &right) {
    matrix = {};
    right = {};
    set_frequency(fit.frequency);
    const std::vector<Real> by_frequency = derivative(fit);
    for (size_t k = 0; k < points_.size(); k++) {
        const auto [c, s] = cis_[k];
        const Vector row = {1, c, s, by_frequency[k]};
        const Real rest = gap(fit, k);
        for (size_t i = 0; i < kParameters; i++) {
            const Real part = points_[k].w * row[i];
            right[i] += part * rest;
            for (size_t j = 0; j <= i; j++)
                matrix[i][j] += part * row[j];
        }
    }
    for (size_t i = 0; i < kParameters; i++)
        for (size_t j = i + 1; j < kParameters; j++)
            matrix[i][j] = matrix[j][i];
    if (first_ == 1) { // fixed mean: the row of the offset becomes that of the identity
        for (size_t i = 0; i < kParameters; i++)
            matrix[0][i] = matrix[i][0] = 0;
        matrix[0][0] = 1;
        right[0] = 0;
    }
}

Cis Sinusoid::mean_cis() const {
    Cis mean = {0, 0};
    for (size_t i = 0; i < points_.size() && first_ == 0; i++) {
        mean.cosine += points_[i].w * cis_[i].cosine;
        mean.sine += points_[i].w * cis_[i].sine;
    }
    return mean;
}

Moments<Real> Sinusoid::cis_moments(const Cis &cis_mean) const noexcept {
    Moments<Real> m = {};
    for (size_t i = 0; i < points_.size(); i++) {
        const Real c = cis_[i].cosine - cis_mean.cosine, s = cis_[i].sine - cis_mean.sine, wc = points_[i].w * c;
        m.cc += wc * c;
        m.cs += wc * s;
        m.ss += points_[i].w * s * s;
    }
    m.determinant = m.cc * m.ss - m.cs * m.cs;
    return m;
}

void Sinusoid::add_correction(Fit &fit, const Cis &cis_mean, Moments<Real> moments) const {
    Real mean = 0;
    for (size_t i = 0; i < points_.size(); i++) {
        const Real part = points_[i].w * gap(fit, i);
        mean += part;
        moments.yc += part * (cis_[i].cosine - cis_mean.cosine);
        moments.ys += part * (cis_[i].sine - cis_mean.sine);
    }
    // Phases and means are rounded to about 2^-60: a smaller eigenvalue (its square, 1e-34) is not significant.
    const Solved solved = period::solve(moments, 1e-34L + kCoincident * (moments.cc + moments.ss));
    fit.rank = solved.rank;
    fit.cosine += solved.cosine;
    fit.sine += solved.sine;
    if (first_ == 0)
        fit.offset += mean - solved.cosine * cis_mean.cosine - solved.sine * cis_mean.sine;
}

Fit Sinusoid::at(Real frequency) {
    set_frequency(frequency);
    const Cis cis_mean = mean_cis();
    const Moments<Real> moments = cis_moments(cis_mean);
    Fit fit = {frequency, 0, 0, 0, 0, 0};
    add_correction(fit, cis_mean, moments);
    add_correction(fit, cis_mean, moments); // iterative refinement: removes the rounding error of the first solution
    for (size_t i = 0; i < points_.size(); i++) {
        const Real rest = gap(fit, i);
        fit.residual += points_[i].w * rest * rest;
    }
    return fit;
}

bool Sinusoid::is_negligible(const Vector &step, const Vector &right, const Fit &fit) const noexcept {
    const Real reduction = std::inner_product(step.begin(), step.end(), right.begin(), Real{0});
    return freedom(fit) > 0 && reduction < 1e-18L * fit.residual / freedom(fit);
}

Fit Sinusoid::refine(Fit best, Real low, Real high) {
    constexpr int max_steps = 60;
    Matrix matrix;
    Vector right, step = {};
    Real damping = 1;
    for (int i = 0; i < max_steps && damping > 1e-6L; i++) {
        normal(best, matrix, right);
        if (!solve(matrix, right, step) || is_negligible(step, right, best))
            break;
        const Fit fit = at(std::fmin(high, std::fmax(low, best.frequency + damping * step[3])));
        if (fit.residual < best.residual) {
            best = fit;
            damping = std::fmin(1.0L, 2 * damping);
        } else {
            damping /= 4;
        }
    }
    return best;
}

void Sinusoid::errors(const Fit &fit, Peak &peak) {
    peak.frequency_error = peak.amplitude_error = kUndetermined;
    const Real amplitude = std::hypot(fit.cosine, fit.sine);
    if (!(freedom(fit) > 0 && amplitude > 0))
        return;
    const Real scale = fit.residual / freedom(fit), c = fit.cosine / amplitude, s = fit.sine / amplitude;
    Matrix matrix;
    Vector right, column = {};
    normal(fit, matrix, right);
    if (fit.rank < 2) { // cosine and sine coincide: the frequency is undetermined
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

void Sinusoid::judge(const Fit &fit, Peak &peak) {
    if (!(freedom(fit) > 0))
        return;
    set_frequency(fit.frequency);
    Real square = 0;
    double largest = 0;
    std::vector<double> sizes(samples_);
    for (size_t i = 0; i < points_.size(); i++) {
        const Point &point = points_[i];
        const Real rest = gap(fit, i);
        square += point.w * weight_ * rest * rest;
        if (i >= samples_) // of a prior
            continue;
        sizes[i] = static_cast<double>(std::fabs(rest) * std::sqrt(point.w * weight_));
        largest = std::fmax(largest, sizes[i]);
    }
    const auto left = static_cast<double>(freedom(fit));
    peak.goodness = goodness_of(static_cast<double>(square) / left, chi_square_sigma(points_.size(), 0, left), largest,
                                kSeriesSigmas);
    const double limit = kOutlierSigmas * std::fmax(robust_sigma(sizes), 1.0);
    peak.outliers =
        static_cast<size_t>(std::count_if(sizes.begin(), sizes.end(), [&](double size) { return size > limit; }));
}

// The power about a peak, at frequencies `step` apart.
class Surroundings {
  public:
    // In [frequency - limit, frequency + limit] and above 0.
    Surroundings(const Stream &stream, const Samples &samples, double frequency, double limit, double power);
    // Distance from the peak to where the power has fallen to half, in this direction, 1 or -1; 0 if that is too far.
    double half_power(int direction) const noexcept;

  private:
    // Polynomial through the powers at points first to first + 7, at `place` in steps from the first point of all.
    double interpolated(size_t first, double place) const noexcept;

    static constexpr double kPointsPerUnit = 50; // per 1/(time span)
    static constexpr double kMostPoints = 8192;  // in one direction
    static constexpr size_t kDegree = 7;
    double half_, step_ = 0;
    size_t peak_ = 0; // the point of the peak
    std::vector<double> power_;
};

Surroundings::Surroundings(const Stream &stream, const Samples &samples, double frequency, double limit, double power)
    : half_(power / 2) {
    const double unit = 1 / cadence_of(stream).span, points = std::ceil(limit * kPointsPerUnit / unit);
    step_ = limit / std::fmin(points, kMostPoints);
    peak_ = static_cast<size_t>(std::fmin(std::fmin(points, kMostPoints), frequency / step_));
    BatchJob job;
    job.grid = stream.grid();
    job.grid.f0 = std::fmax(0, frequency - static_cast<double>(peak_) * step_);
    job.grid.df = step_;
    job.grid.nf = static_cast<int64_t>(peak_ + static_cast<size_t>(std::fmin(points, kMostPoints))) + 1;
    job.tolerance = std::fmax(1e-10 * half_, kMinTolerance);
    job.threads = 1;
    std::vector<double> sigma; // without sigmas, those of the samples are sigma_floor
    if (samples.sigma == nullptr && stream.grid().basis.any())
        sigma.assign(samples.count, stream.grid().sigma_floor);
    power_.resize(static_cast<size_t>(job.grid.nf));
    batch_power(job,
                {samples.t, samples.y, sigma.empty() ? samples.sigma : sigma.data(), samples.count, samples.columns},
                power_.data());
}

double Surroundings::interpolated(size_t first, double place) const noexcept {
    double sum = 0;
    for (size_t i = first; i <= first + kDegree; i++) {
        double factor = power_[i];
        for (size_t j = first; j <= first + kDegree; j++)
            if (j != i)
                factor *= (place - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
        sum += factor;
    }
    return sum;
}

double Surroundings::half_power(int direction) const noexcept {
    const auto count = static_cast<ptrdiff_t>(power_.size());
    auto k = static_cast<ptrdiff_t>(peak_);
    while (k >= 0 && k < count && power_[static_cast<size_t>(k)] > half_)
        k += direction;
    if (k < 0 || k >= count || power_.size() <= kDegree)
        return 0;
    double inside = static_cast<double>(k - direction), outside = static_cast<double>(k);
    const auto first =
        static_cast<size_t>(std::clamp<ptrdiff_t>(std::min(k, k - direction) - static_cast<ptrdiff_t>(kDegree / 2), 0,
                                                  count - static_cast<ptrdiff_t>(kDegree) - 1));
    for (int i = 0; i < 40; i++) {
        const double middle = 0.5 * (inside + outside);
        (interpolated(first, middle) > half_ ? inside : outside) = middle;
    }
    return std::fabs(inside - static_cast<double>(peak_)) * step_;
}

// The half-power points are 0.6/(time span) from the peak.
double width_of(const Stream &stream, const Samples &samples, const Peak &peak) {
    const double span = cadence_of(stream).span, limit = std::fmax(5 / span, 20 * stream.grid().df);
    if (!(span > 0 && std::isfinite(peak.frequency + limit)))
        return kUndetermined;
    try {
        const Surroundings around(stream, samples, peak.frequency, limit, peak.power);
        const double below = around.half_power(-1), above = around.half_power(1);
        return below > 0 && above > 0 ? below + above : kUndetermined;
    } catch (const Error &) { // above the grid, phases may be beyond 2^50 cycles
        return kUndetermined;
    }
}

} // namespace

Peak fit_peak(const Stream &stream, const Samples &samples) {
    Peak peak = find_peak(stream);
    check_pushed(stream, samples);
    Sinusoid sinusoid(stream, samples);
    const Fit parabola = sinusoid.at(peak.frequency), grid = sinusoid.at(peak.grid_frequency);
    // Search within one grid step, and not outside the grid: powers there were not compared with the peak's.
    const Fit start = parabola.residual < grid.residual ? parabola : grid;
    const Real step = stream.grid().df, first = stream.grid().f0, last = stream.grid().last();
    const Fit fit =
        sinusoid.refine(start, std::fmax(first, start.frequency - step), std::fmin(last, start.frequency + step));
    peak.at_edge = fit.frequency <= first || fit.frequency >= last;
    const Real ratio = fit.rank > 0 ? std::fmin(1.0L, fit.residual / sinusoid.total()) : 1;
    peak.frequency = static_cast<double>(fit.frequency);
    peak.power = static_cast<double>(1 - ratio);
    peak.log10_residual = static_cast<double>(std::log10(std::fmax(ratio, kMinResidualRatio)));
    peak.fwhm = fit.rank > 0 && peak.power > 0 ? width_of(stream, samples, peak) : kUndetermined;
    sinusoid.errors(fit, peak);
    if (samples.sigma != nullptr)
        sinusoid.judge(fit, peak);
    // From cosine and sine about the mean time to a sine about time_offset.
    const Real shift =
        kTwoPi * cycles_of(fit.frequency, static_cast<Real>(stream.grid().time_offset) - sinusoid.mean_time());
    const Real phase = std::atan2(fit.cosine, fit.sine) + shift;
    peak.phase = static_cast<double>(std::remainder(phase, kTwoPi));
    peak.amplitude = static_cast<double>(std::hypot(fit.cosine, fit.sine));
    peak.offset = static_cast<double>(sinusoid.offset(fit));
    return peak;
}

} // namespace toliman::period
