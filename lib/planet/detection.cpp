// Method: with what the nuisance functions leave of cosine and sine, whitened, C and S, the power at a frequency is
// G/|r|^2 with the gain G = b^T M^-1 b, the normal equations M of C and S, b = (C r, S r) and the residuals r.
//
// The upper limit: of circular orbits with an amplitude A and a random phase, noise gives a smaller gain than that of
// the series to the share 1 - probability. With the unit vector u of a phase, G has the distribution of chi-square with
// 2 degrees of freedom, not central by A^2 u^T M u: the probability that (sqrt(A^2 u^T M u) + n_1)^2 + n_2^2 is below
// G, with standard normal n, is elementary in n_1; n_2 and the phase are sums over equal steps, whose errors fall
// exponentially. This is the limit of Cumming et al. (1999, ApJ 526, 890), without their simulations.
//
// A gain below the 16 % point of noise counts as that point: a series excludes nothing because its noise happens to be
// small (Cowan et al. 2011, arXiv:1105.3166, power-constrained limits).
//
// Tried: the quantile of the posterior with a uniform prior of the amplitude. Where functions describe nearly all of
// one phase, as trends do of long periods, it excluded up to 14 % of true planets in place of 5 %, and was up to three
// times as large.
#include "planet/detection.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

namespace toliman::planet {

namespace {

constexpr int kPhases = 64;             // in a quarter of a turn
constexpr int kSteps = 32;              // of n_2, in half of its range
constexpr double kFarthest = 8;         // standard deviations of n_2
constexpr double kLimitAccuracy = 1e-6; // of a limit, relative
constexpr double kLeastShare = 0.16;    // of noise, below the gain of a limit

double time_variance(const Series &series, const Buffer<double> &weights) noexcept {
    double all = 0, mean = 0, square = 0;
    for (size_t i = 0; i < series.n; i++) {
        const double w = weights[i] * weights[i];
        all += w;
        mean += w * series.t[i];
        square += w * series.t[i] * series.t[i];
    }
    mean /= all;
    return std::max(square / all - mean * mean, 0.0);
}

double normal_share(double x) noexcept {
    return std::erfc(-x * std::sqrt(0.5)) / 2;
}

// Probability that (length + n_1)^2 + n_2^2 is below a square. n_2 = end sin(angle), so that the integrand is smooth.
double share_below(double square, double length) noexcept {
    const double end = std::min(std::sqrt(square), kFarthest);
    double sum = 0;
    for (int i = 0; i < kSteps; i++) {
        const double angle = kPi / 2 * (i + 0.5) / kSteps, n2 = end * std::sin(angle);
        const double reach = std::sqrt(std::max(square - n2 * n2, 0.0));
        sum +=
            std::cos(angle) * std::exp(-n2 * n2 / 2) * (normal_share(reach - length) - normal_share(-reach - length));
    }
    return sum * end * std::sqrt(kPi / 2) / kSteps;
}

} // namespace

period::Sampling sampling_of(const Series &series, const Design &design, const Frequencies &grid) noexcept {
    return {static_cast<int64_t>(series.used), grid.at(grid.count - 1), time_variance(series, design.weights()),
            static_cast<int64_t>(design.free())};
}

CircularPair circular_pair(const Moments &moments) noexcept {
    return {{moments.right[0], moments.right[1]}, moments.matrix[0][0], moments.matrix[1][0], moments.matrix[1][1]};
}

// b^T M^-1 b. Cosine and sine of which the functions leave only one phase, as at half the inverse of even steps, have a
// singular M.
double CircularPair::gain() const noexcept {
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-12 * xx * yy))
        return 0;
    return (right[0] * right[0] * yy - 2 * right[0] * right[1] * xy + right[1] * right[1] * xx) / determinant;
}

Frequencies detection_grid(const Series &series, const Prior &prior) noexcept {
    const double step = 0.1 / series.span;
    return {prior.frequency_min, step, static_cast<size_t>((prior.frequency_max - prior.frequency_min) / step) + 1};
}

Detection::Detection(const Problem &problem, const Design &design, double fap)
    : problem_(problem), design_(design), grid_(detection_grid(problem.series, problem.prior)),
      log10_threshold_(
          period::log10_threshold(period::Fap::baluev, sampling_of(problem.series, design, grid_), std::log10(fap))) {}

CircularPair Detection::pair_at(double frequency) const {
    ShapeWork work(problem_.series);
    return circular_pair(work.moments(problem_.series, design_, {frequency, 0, 0}));
}

double Detection::log10_fap() const {
    double highest = 0;
    for (size_t i = 0; i < grid_.count; i++)
        highest = std::max(highest, pair_at(grid_.at(i)).gain());
    const double left = design_.square() > 0 ? 1 - highest / design_.square() : 1;
    const double log10_residual =
        std::clamp(left > 0 ? std::log10(left) : period::kMinLogResidual, period::kMinLogResidual, 0.0);
    return period::log10_fap(period::Fap::baluev, sampling_of(problem_.series, design_, grid_), log10_residual);
}

double Detection::upper(double frequency, double probability) const {
    const CircularPair pair = pair_at(frequency);
    const double trace = pair.xx + pair.yy, root = std::hypot(pair.xx - pair.yy, 2 * pair.xy);
    if (!(trace > 0))
        return HUGE_VAL;
    const double most = (trace + root) / 2, least = std::max((trace - root) / 2, 0.0); // squares along the axes
    const double gain = std::max(pair.gain(), -2 * std::log1p(-kLeastShare));
    const auto is_excluded = [&](double amplitude) {
        double sum = 0;
        for (int i = 0; i < kPhases; i++) {
            const double cosine = std::cos(kPi / 2 * (i + 0.5) / kPhases);
            sum += share_below(gain, amplitude * std::sqrt(least + (most - least) * cosine * cosine));
        }
        return sum / kPhases < 1 - probability;
    };
    if (is_excluded(0))
        return 0;
    double high = std::sqrt(gain / most), low = 0;
    for (; !is_excluded(high) && std::isfinite(high); high *= 2)
        low = high;
    while (high - low > kLimitAccuracy * high) {
        const double middle = (low + high) / 2;
        (is_excluded(middle) ? high : low) = middle;
    }
    return high;
}

} // namespace toliman::planet
