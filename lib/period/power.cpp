#include "period/power.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/power.hpp"

namespace toliman::period {

// b^T M^+ b in the eigenvectors of M = (cc, cs; cs, ss), so that a small eigenvalue cannot blur the large one's share.
Solved solve(const Moments &m, long double noise) noexcept {
    const long double half_gap = (m.cc - m.ss) / 2, radius = std::sqrt(half_gap * half_gap + m.cs * m.cs);
    const long double large = (m.cc + m.ss) / 2 + radius;
    if (!(large > noise))
        return {0, 0, 0, 0};
    // The eigenvector of the large eigenvalue, from the row that does not cancel.
    long double u = half_gap >= 0 ? half_gap + radius : m.cs, v = half_gap >= 0 ? m.cs : radius - half_gap;
    if (radius == 0)
        u = 1;
    const long double square = u * u + v * v, along = u * m.yc + v * m.ys, most = along / (square * large);
    Solved solved = {u * most, v * most, along * most, 1};
    const long double small = m.determinant / large;
    if (small > noise) {
        const long double across = u * m.ys - v * m.yc, rest = across / (square * small);
        solved = {solved.cosine - v * rest, solved.sine + u * rest, solved.explained + across * rest, 2};
    }
    return solved;
}

double explained_share(const Solved &solved, long double spread, bool fixed_mean, int64_t samples) noexcept {
    if (solved.rank > 0 && solved.rank + (fixed_mean ? 0 : 1) >= samples)
        return 1;
    return static_cast<double>(std::clamp(solved.explained / spread, 0.0L, 1.0L));
}

PowerQuery::PowerQuery(const Stream &stream) noexcept
    : stream_(stream), part_(0), mean_(0), spread_(0), share_(0), noise_(0) {
    const Wide weight = stream.weight();
    if (!(weight > 0))
        return;
    part_ = 1 / weight;
    mean_ = stream.mean();
    spread_ = stream.spread();
    share_ = static_cast<long double>(stream.totals().count) * static_cast<long double>(part_);
    // Quantisation of each term, and sine and cosine: in wide sums both belong to one phase, and errors come squared.
    noise_ = stream.grid().wide() ? share_ * 0x1p-99L + 4e-31L : share_ * 0x1p-51L + 4e-16L;
}

bool PowerQuery::meaningful() const noexcept {
    return stream_.totals().count >= 5 && spread_ > 0;
}

void PowerQuery::check() const {
    if (!(spread_ > 0))
        return;
    const Grid &grid = stream_.grid();
    // Terms w y are kept to `unit`; cosine and sine may vary as little as the weights, relative to the heaviest sample.
    const long double unit = grid.wide() ? 0x1p-150L : 0x1p-100L, varies = grid.sigma_floor / grid.sigma_ceiling;
    const long double least = 1e12L * unit * share_ / varies, spread = std::sqrt(spread_);
    if (spread < least)
        fail(Status::range,
             "values scatter by %.3Lg about their mean, value_bound = %g keeps 12 digits from %.3Lg on: create with a "
             "smaller value_bound",
             spread * grid.value_bound, grid.value_bound, least * grid.value_bound);
}

template <class Real> Moments PowerQuery::moments(int64_t k) const noexcept {
    const SumsAt<Real> sums = stream_.sums<Real>(k);
    const Real part = static_cast<Real>(part_), half = part / 2, mean = static_cast<Real>(mean_);
    const Real c = sums.c1 * part, s = sums.s1 * part, one_half = static_cast<Real>(0.5);
    Real cc = one_half + sums.c2 * half, ss = one_half - sums.c2 * half, cs = sums.s2 * half;
    if (!stream_.grid().fixed_mean) {
        cc -= c * c;
        ss -= s * s;
        cs -= c * s;
    }
    const Real yc = sums.yc * part - mean * c, ys = sums.ys * part - mean * s;
    return {static_cast<long double>(cc), static_cast<long double>(cs), static_cast<long double>(ss),
            static_cast<long double>(yc), static_cast<long double>(ys), static_cast<long double>(cc * ss - cs * cs)};
}

double PowerQuery::at(int64_t k) const noexcept {
    if (!(spread_ > 0))
        return 0;
    const Grid &grid = stream_.grid();
    const Moments m = grid.wide() ? moments<Wide>(k) : moments<long double>(k);
    const Solved solved = solve(m, noise_ + kCoincident * (m.cc + m.ss));
    return explained_share(solved, spread_, grid.fixed_mean, stream_.totals().count);
}

void PowerQuery::range(int64_t first, size_t count, double *power) const noexcept {
    const Grid &grid = stream_.grid();
    const int64_t samples = stream_.totals().count;
    const bool vectors = spread_ > 0 && !grid.wide() && samples > 3 && samples < int64_t{1} << 34;
    if (vectors) {
        const int64_t *lo[kernels::kNarrowSums], *hi[kernels::kNarrowSums];
        for (size_t sum = 0; sum < kernels::kNarrowSums; sum++) {
            lo[sum] = stream_.low(sum, first);
            hi[sum] = stream_.high(sum, first);
        }
        kernels::PowerShared shared = {};
        shared.part = static_cast<double>(part_);
        shared.mean_high = static_cast<double>(mean_);
        shared.mean_low = static_cast<double>(mean_ - static_cast<Wide>(shared.mean_high));
        shared.spread = static_cast<double>(spread_);
        shared.fixed_mean = grid.fixed_mean;
        kernels::power_kernels().power(lo, hi, count, shared, power);
    }
    for (size_t i = 0; i < count; i++)
        if (!vectors || power[i] == kernels::kNeedsMore)
            power[i] = at(first + static_cast<int64_t>(i));
}

} // namespace toliman::period
