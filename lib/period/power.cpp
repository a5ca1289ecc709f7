#include "period/power.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::period {

namespace {

// b^T M^+ b for the symmetric 2 x 2 matrix M = (cc, cs; cs, ss), directions with eigenvalues up to `noise` left out.
struct Solved {
    long double explained;
    int rank;
};

Solved solve(long double cc, long double cs, long double ss, long double yc, long double ys,
             long double noise) noexcept {
    const long double half_gap = (cc - ss) / 2, radius = std::hypot(half_gap, cs);
    const long double large = (cc + ss) / 2 + radius;
    if (!(large > noise))
        return {0, 0};
    const long double determinant = cc * ss - cs * cs;
    if (determinant / large > noise)
        return {(ss * yc * yc + cc * ys * ys - 2 * cs * yc * ys) / determinant, 2};
    // The eigenvector of the large eigenvalue, from the row that does not cancel.
    const long double u = half_gap >= 0 ? half_gap + radius : cs, v = half_gap >= 0 ? cs : radius - half_gap;
    const long double along = u * yc + v * ys;
    return {along * along / ((u * u + v * v) * large), 1};
}

} // namespace

PowerQuery::PowerQuery(const Stream &stream) noexcept
    : stream_(stream), weight_(stream.weight()), mean_(0), spread_(0), noise_(0) {
    if (!(weight_ > 0))
        return;
    mean_ = stream.mean();
    spread_ = stream.spread();
    const auto count = static_cast<long double>(stream.totals().count);
    noise_ = count * 0x1p-51L / weight_ + 4e-16L; // quantisation of each term, and sine and cosine
}

bool PowerQuery::meaningful() const noexcept {
    return stream_.totals().count >= 5 && spread_ > 0;
}

double PowerQuery::at(int64_t k) const noexcept {
    if (!(spread_ > 0))
        return 0;
    const SumsAt sums = stream_.sums(k);
    const long double c = sums.c1 / weight_, s = sums.s1 / weight_;
    long double cc = (1 + sums.c2 / weight_) / 2, ss = (1 - sums.c2 / weight_) / 2, cs = sums.s2 / weight_ / 2;
    const bool floating = !stream_.grid().fixed_mean;
    if (floating) {
        cc -= c * c;
        ss -= s * s;
        cs -= c * s;
    }
    const Solved solved = solve(cc, cs, ss, sums.yc / weight_ - mean_ * c, sums.ys / weight_ - mean_ * s, noise_);
    if (solved.rank > 0 && solved.rank + (floating ? 1 : 0) >= stream_.totals().count)
        return 1; // as many free parameters as samples
    return static_cast<double>(std::clamp(solved.explained / spread_, 0.0L, 1.0L));
}

} // namespace toliman::period
