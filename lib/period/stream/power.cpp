// Method: linear least squares of y = offset + a cos + b sin at each frequency, from the six sums of stream.cpp
// (Zechmeister and Kuerster 2009, A&A 496, 577). With the covariance matrix M of cosine and sine, and their covariances
// b with y, the power is P = b^T M^+ b / var y. The pseudo-inverse is formed in the eigenvectors of M, so that the
// error of a small eigenvalue (a span of less than a cycle, aliases) does not affect the contribution of the large one.
// Precision: a vectorised kernel in double where det M is large (2 to 4 ns per frequency, otherwise about 100 ns), long
// double where that keeps enough digits, else 113 bits.
// Rejected: counting cosine and sine as coincident below 1e-17 of the trace also with double-limb accumulators. Powers
// were wrong by 7e-4 where 5e-10 was promised; the limit there is 1e-25.
// Error bound: include/toliman/period.h, Accuracy; from the rounding of terms, of phases and of the mean.
#include "period/stream/power.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/power.hpp"

namespace toliman::period {

namespace {

// Error of a sample's phase in double-limb terms, whose cosine and sine are those of one phase. Single-limb terms have
// larger errors.
constexpr long double kPhaseError = 6e-16L;

template <class Real> long double smaller_eigenvalue(const Moments<Real> &m) noexcept {
    const auto cc = static_cast<long double>(m.cc), ss = static_cast<long double>(m.ss);
    const long double half_gap = (cc - ss) / 2, cs = static_cast<long double>(m.cs);
    return static_cast<long double>(m.determinant) / ((cc + ss) / 2 + std::sqrt(half_gap * half_gap + cs * cs));
}

} // namespace

// Computes b^T M^+ b in the eigenvectors of M = (cc, cs; cs, ss), so that the error of a small eigenvalue does not
// affect the contribution of the large one. The rounding of the eigenvectors enters the result divided by the square
// root of the small eigenvalue.
template <class Real> Solved solve(const Moments<Real> &m, long double noise) noexcept {
    const Real half_gap = (m.cc - m.ss) / 2, radius = root(half_gap * half_gap + m.cs * m.cs);
    const Real large = (m.cc + m.ss) / 2 + radius;
    if (!(large > noise))
        return {0, 0, 0, 0};
    // The eigenvector of the large eigenvalue, from the row without cancellation.
    Real u = half_gap >= 0 ? half_gap + radius : m.cs, v = half_gap >= 0 ? m.cs : radius - half_gap;
    if (radius == 0)
        u = 1;
    const Real square = u * u + v * v, along = u * m.yc + v * m.ys, most = along / (square * large);
    Real cosine = u * most, sine = v * most, explained = along * most;
    const Real small = m.determinant / large;
    const int rank = small > noise ? 2 : 1;
    if (rank == 2) {
        const Real across = u * m.ys - v * m.yc, rest = across / (square * small);
        cosine -= v * rest;
        sine += u * rest;
        explained += across * rest;
    }
    return {static_cast<long double>(cosine), static_cast<long double>(sine), static_cast<long double>(explained),
            rank};
}
template Solved solve(const Moments<long double> &, long double) noexcept;
#ifdef TOLIMAN_QUAD_IS_WIDER
template Solved solve(const Moments<Quad> &, long double) noexcept;
#endif

double explained_share(const Solved &solved, long double spread, int64_t free, int64_t samples) noexcept {
    if (solved.rank > 0 && solved.rank + free >= samples)
        return 1;
    return static_cast<double>(std::clamp(solved.explained / spread, 0.0L, 1.0L));
}

PowerQuery::PowerQuery(const Stream &stream) noexcept
    : PowerQuery(stream, stream.grid().double_limb() ? kCoincidentDoubleLimb : kCoincident) {}

PowerQuery::PowerQuery(const Stream &stream, long double coincident) noexcept
    : stream_(stream), weight_(stream.weight()), inverse_weight_(0), mean_(0), spread_(0), samples_over_weight_(0),
      noise_(0), error_(0), coincident_(coincident), free_(stream.grid().fixed_mean ? 0 : 1) {
    if (!(weight_ > 0))
        return;
    inverse_weight_ = 1 / weight_;
    mean_ = stream.mean_sum() / weight_;
    spread_ = stream.spread();
    samples_over_weight_ = static_cast<long double>(stream.totals().count) * static_cast<long double>(inverse_weight_);
    // Quantisation of each term, plus the errors of cosine and sine. In double-limb terms these are cosine and sine of
    // one phase, so that their error moves a point on the unit circle and enters the eigenvalue squared.
    noise_ = stream.grid().double_limb() ? samples_over_weight_ * 0x1p-99L + 4e-31L
                                         : samples_over_weight_ * 0x1p-51L + 4e-16L;
    if (spread_ > 0)
        error_ = (stream.grid().double_limb() ? 1e-28L : 4e-15L) * samples_over_weight_ *
                 (1 + std::fabs(static_cast<long double>(mean_)) / std::sqrt(spread_));
    if (stream.grid().basis.any())
        project();
}

void PowerQuery::project() noexcept {
    projection_.emplace(stream_);
    free_ = static_cast<int64_t>(projection_->free());
    spread_ = projection_->spread();
    noise_ = error_ = 0; // Moments::noise instead
}

int64_t PowerQuery::least_samples() const noexcept {
    return 4 + std::max<int64_t>(1, free_);
}

bool PowerQuery::meaningful() const noexcept {
    return stream_.totals().count >= least_samples() && spread_ > 0;
}

// Standard deviation of the values from which the power has 12 digits. Terms w y are rounded to `unit`, and where one
// sample outweighs the others, cosine and sine may vary by no more than sigma_floor/sigma_ceiling.
long double PowerQuery::min_spread() const noexcept {
    const Grid &grid = stream_.grid();
    const long double unit = grid.double_limb() ? 0x1p-150L : 0x1p-100L,
                      sigma_ratio = grid.sigma_floor / grid.sigma_ceiling;
    return 1e12L * unit * samples_over_weight_ / sigma_ratio;
}

bool PowerQuery::resolved() const noexcept {
    return !(spread_ > 0) || std::sqrt(spread_) >= min_spread();
}

void PowerQuery::check() const {
    const Grid &grid = stream_.grid();
    if (!resolved())
        fail(Status::range,
             "standard deviation of the values = %.3g: {value_bound} = %g resolves 12 digits from %.3g: create with a "
             "smaller "
             "value_bound",
             static_cast<double>(std::sqrt(spread_) * grid.value_bound), grid.value_bound,
             static_cast<double>(min_spread() * grid.value_bound));
}

template <class Real> Moments<Real> PowerQuery::moments(int64_t k) const noexcept {
    const SumsAt<Real> sums = stream_.sums<Real>(k);
    const Real part = static_cast<Real>(inverse_weight_), half = part / 2, mean = static_cast<Real>(mean_);
    const Real c = sums.c1 * part, s = sums.s1 * part, one_half = static_cast<Real>(0.5);
    Real cc = one_half + sums.c2 * half, ss = one_half - sums.c2 * half, cs = sums.s2 * half;
    if (!stream_.grid().fixed_mean) {
        cc -= c * c;
        ss -= s * s;
        cs -= c * s;
    }
    const Real yc = sums.yc * part - mean * c, ys = sums.ys * part - mean * s;
    return {cc, cs, ss, yc, ys, cc * ss - cs * cs};
}

template <class Use> auto PowerQuery::with_moments(int64_t k, Use use) const noexcept {
    // With a determinant above the first limit and a mean within the second (in standard deviations), cancellation
    // costs at most three of the 19 digits of long double.
    constexpr long double kWellConditioned = 1e-3L, kNearMean = 1e3L;
    if (projection_)
        return projection_->with_moments(k, use);
    const auto mean = static_cast<long double>(mean_);
    const Moments<long double> in_long_double = moments<long double>(k);
    const bool cancels = in_long_double.determinant < kWellConditioned || mean * mean > kNearMean * kNearMean * spread_;
    return stream_.grid().double_limb() && cancels ? use(moments<Quad>(k)) : use(in_long_double);
}

// Error bound of the power, with the smallest eigenvalue that enters.
template <class Real> long double PowerQuery::error_bound(const Moments<Real> &m, long double small) const noexcept {
    if (projection_)
        return 8 * (m.noise / small + m.value_noise / std::sqrt(small));
    return error_ / small + kPhaseError / std::sqrt(small);
}

template <class Real> bool PowerQuery::error_exceeds(const Moments<Real> &m, long double tolerance) const noexcept {
    const long double small = smaller_eigenvalue(m);
    return !(small > 0 && error_bound(m, small) < tolerance);
}

bool PowerQuery::inaccurate(int64_t k) const noexcept {
    return frequency(k) > 0 && with_moments(k, [&](const auto &m) { return error_exceeds(m, kInaccurate); });
}

// The vectorised kernel rejects frequencies with a small determinant. The determinant is at most the smaller
// eigenvalue, since the trace is at most 1, so that those with a large determinant meet the tolerance.
template <class Counts> bool PowerQuery::any_error_exceeds(long double tolerance, Counts counts) const noexcept {
    constexpr int64_t kAtOnce = 512;
    double power[kAtOnce];
    const Grid &grid = stream_.grid();
    const bool vectorised = vectorisable() && error_ < tolerance * kernels::kLeastDeterminant;
    for (int64_t first = grid.f0 > 0 ? 0 : 1; first < grid.nf; first += kAtOnce) {
        const int64_t count = std::min(kAtOnce, grid.nf - first);
        if (vectorised)
            range_by_vectors(first, static_cast<size_t>(count), power);
        for (int64_t i = 0; i < count; i++)
            if ((!vectorised || power[i] == kernels::kNeedsMore) && counts(first + i) &&
                with_moments(first + i, [&](const auto &m) { return error_exceeds(m, tolerance); }))
                return true;
    }
    return false;
}

bool PowerQuery::needs_double_limb() const noexcept {
    constexpr long double kTolerated = 1e-9L;
    return meaningful() && !stream_.grid().double_limb() && any_error_exceeds(kTolerated, [](int64_t) { return true; });
}

bool PowerQuery::any_inaccurate(double nyquist) const noexcept {
    constexpr double kRounding = 1e-9;
    return meaningful() && any_error_exceeds(kInaccurate, [&](int64_t k) {
               const double part = frequency(k) / nyquist, multiple = std::nearbyint(part);
               return !(multiple > 0 && std::fabs(part - multiple) <= kRounding * part);
           });
}

template <class Real> Solved PowerQuery::solved(const Moments<Real> &m) const noexcept {
    return solve(m, noise_ + m.noise + coincident_ * static_cast<long double>(m.cc + m.ss));
}

Solved PowerQuery::solved(int64_t k) const noexcept {
    return with_moments(k, [&](const auto &m) { return solved(m); });
}

double PowerQuery::at(int64_t k) const noexcept {
    if (!(spread_ > 0))
        return 0;
    return explained_share(solved(k), spread_, free_, stream_.totals().count);
}

Model PowerQuery::model(int64_t k) const noexcept {
    return with_moments(k, [&](const auto &m) { return model(k, m); });
}

template <class Real> Model PowerQuery::model(int64_t k, const Moments<Real> &m) const noexcept {
    const Grid &grid = stream_.grid();
    const Solved best = solved(m);
    const auto part = static_cast<long double>(inverse_weight_), bound = static_cast<long double>(grid.value_bound);
    const SumsAt<Quad> sums = stream_.sums<Quad>(k);
    const bool moving = !grid.fixed_mean;
    const long double c = moving ? static_cast<long double>(sums.c1) * part : 0;
    const long double s = moving ? static_cast<long double>(sums.s1) * part : 0;
    const auto infinity = std::numeric_limits<long double>::infinity();

    Model model = {};
    model.rank = best.rank;
    model.inaccurate = frequency(k) > 0 && error_exceeds(m, kInaccurate);
    model.power = static_cast<double>(std::clamp(best.explained / spread_, 0.0L, 1.0L));
    const long double amplitude = std::hypot(best.cosine, best.sine);
    const long double offset = static_cast<long double>(mean_) - best.cosine * c - best.sine * s;
    // Variances are `scale` times the inverse of M; a direction that is not fitted is undetermined.
    const long double scale = this->scale(best);
    const auto variance = [&](Real u, Real v) { // of u cosine + v sine
        const Real per_scale = (u * u * m.ss - 2 * u * v * m.cs + v * v * m.cc) / m.determinant;
        return best.rank == 2 ? scale * static_cast<long double>(per_scale) : infinity;
    };
    const long double a = amplitude > 0 ? best.cosine / amplitude : 1, b = amplitude > 0 ? best.sine / amplitude : 0;
    const long double single = scale / static_cast<long double>(a * a * m.cc + 2 * a * b * m.cs + b * b * m.ss);
    const auto error = [&](long double square) { return static_cast<double>(bound * std::sqrt(square)); };
    model.amplitude = static_cast<double>(bound * amplitude);
    model.amplitude_error = error(best.rank == 1 ? single : variance(a, b));
    model.phase = static_cast<double>(std::atan2(best.cosine, best.sine));
    model.phase_error = static_cast<double>(std::sqrt(variance(-b, a)) / amplitude);
    model.offset = static_cast<double>(bound * offset + static_cast<long double>(grid.value_offset));
    model.offset_error = moving ? error(scale + (best.rank == 2 ? variance(c, s) : 0)) : 0;
    if (projection_) {
        Coefficients functions;
        projection_->coefficients(k, best, scale, functions);
        model.offset = functions.value[0];
        model.offset_error = functions.error[0];
    }
    return model;
}

long double PowerQuery::scale(const Solved &best) const noexcept {
    const auto freedom = static_cast<long double>(stream_.totals().count) - best.rank - static_cast<long double>(free_);
    const long double residual = std::fmax(0.0L, spread_ - best.explained);
    return freedom > 0 ? residual / freedom : std::numeric_limits<long double>::infinity();
}

Coefficients PowerQuery::coefficients(int64_t k) const noexcept {
    Coefficients out;
    const Solved best = solved(k);
    projection_->coefficients(k, best, scale(best), out);
    return out;
}

double PowerQuery::half_chi_square() const noexcept {
    if (!(inverse_weight_ > 0))
        return 0;
    const long double unit = static_cast<long double>(stream_.grid().value_bound) / stream_.grid().sigma_floor;
    return static_cast<double>(spread_ / static_cast<long double>(inverse_weight_) / 2 * unit * unit);
}

// Returns whether the vectorised kernel is accurate for the frequencies that it does not reject.
bool PowerQuery::vectorisable() const noexcept {
    const int64_t samples = stream_.totals().count;
    const long double limit = static_cast<long double>(mean_) / kernels::kFarthestMean;
    // The kernel omits the lowest limbs of double-limb accumulators. They are negligible unless the values hardly
    // scatter.
    const bool needs_lowest =
        stream_.grid().double_limb() && samples_over_weight_ * 0x1p-101L > 1e-15L * std::sqrt(spread_);
    if (projection_)
        return projection_->vectorisable() && !needs_lowest && samples > least_samples();
    return spread_ > limit * limit && !needs_lowest && samples > 3 && samples < int64_t{1} << 32;
}

// Powers by the vectorised kernel; kNeedsMore at the frequencies that it rejects.
size_t PowerQuery::range_by_vectors(int64_t first, size_t count, double *power) const noexcept {
    if (projection_)
        return projection_->range(first, count, power);
    const Grid &grid = stream_.grid();
    const int64_t *lo[kernels::kSums], *hi[kernels::kSums];
    for (size_t sum = 0; sum < grid.sums(); sum++) {
        lo[sum] = stream_.low(sum, first);
        hi[sum] = stream_.high(sum, first);
    }
    kernels::PowerShared shared = {};
    shared.weight = static_cast<double>(weight_);
    shared.samples = stream_.totals().count;
    shared.mean_high = static_cast<double>(mean_);
    shared.mean_low = static_cast<double>(mean_ - static_cast<Quad>(shared.mean_high));
    shared.spread = static_cast<double>(spread_);
    shared.fixed_mean = grid.fixed_mean;
    const kernels::PowerKernels &known = kernels::power_kernels();
    return (grid.double_limb() ? known.power_double_limb : known.power)(lo, hi, count, shared, power);
}

// Returns whether some set of samples can have these moments: no negative eigenvalue, and explained variance at most
// the variance of the values, up to rounding. Retracting a sample that was never pushed can violate both; a power above
// 1, clamped to 1, would then look like a perfect fit. A genuine perfect fit explains the variance within the error
// bound of the power (include/toliman/period.h, Accuracy), which grows as the smaller eigenvalue decreases. Four times
// that bound, at least 1e-9, separates the two cases.
template <class Real> bool PowerQuery::consistent(const Moments<Real> &m) const noexcept {
    constexpr long double kFloor = 1e-9L, kMargin = 4;
    const Solved best = solved(m);
    // With as many parameters as samples the power is 1 by definition.
    if (best.rank > 0 && best.rank + free_ >= stream_.totals().count)
        return true;
    const auto trace = static_cast<long double>(m.cc + m.ss), small = smaller_eigenvalue(m);
    if (!(trace >= -kFloor && (best.rank == 0 || small >= -kFloor - kMargin * (noise_ + m.noise))))
        return false;
    // With rank 1 the smaller eigenvalue does not enter.
    const long double least = best.rank == 2 ? small : trace;
    const long double bound = error_bound(m, least);
    return best.rank == 0 || best.explained <= spread_ * (1 + std::fmax(kFloor, kMargin * bound));
}

void PowerQuery::check_power(int64_t k, double power) const {
    if (stream_.retracted() && !stream_.rereferenced() && power >= 1 &&
        !with_moments(k, [&](const auto &m) { return consistent(m); }))
        fail(Status::state, "the sums at frequency %g give a power above 1: a retracted sample was never pushed",
             frequency(k));
}

void PowerQuery::range(int64_t first, size_t count, double *power) const noexcept {
    const bool vectorised = vectorisable();
    if (vectorised && range_by_vectors(first, count, power) == 0)
        return;
    for (size_t i = 0; i < count; i++)
        if (!vectorised || power[i] == kernels::kNeedsMore)
            power[i] = at(first + static_cast<int64_t>(i));
}

void PowerQuery::check_powers(int64_t first, size_t count) const {
    constexpr size_t kAtOnce = 512;
    double powers[kAtOnce];
    for (size_t done = 0; stream_.retracted() && !stream_.rereferenced() && done < count; done += kAtOnce) {
        const size_t some = std::min(kAtOnce, count - done);
        const int64_t from = first + static_cast<int64_t>(done);
        range(from, some, powers);
        for (size_t i = 0; i < some; i++)
            check_power(from + static_cast<int64_t>(i), powers[i]);
    }
}

} // namespace toliman::period
