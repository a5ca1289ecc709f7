#include "period/peak.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "period/power.hpp"

namespace toliman::period {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastResidual = 1e-15; // 1 - power from the sums carries no more digits

// Grid steps from `top`, whose power is `here`, to where it falls through `level` on the side of `direction`.
double crossing(const PowerQuery &query, int64_t nf, int64_t top, double here, int direction, double level) noexcept {
    for (int64_t k = top + direction; k >= 0 && k < nf; k += direction) {
        const double next = query.at(k);
        if (next <= level)
            return static_cast<double>((k - top) * direction - 1) + (here - level) / (here - next);
        here = next;
    }
    return std::numeric_limits<double>::infinity();
}

} // namespace

Peak find_peak(const Stream &stream) {
    const PowerQuery query(stream);
    if (!query.meaningful())
        fail(Status::state, "a peak needs at least five samples that are not all equal; %lld were pushed",
             static_cast<long long>(stream.totals().count));
    query.check();
    const Grid &grid = stream.grid();
    constexpr int64_t kAtOnce = 512;
    double powers[kAtOnce], highest = -1;
    int64_t top = 0;
    for (int64_t first = 0; first < grid.nf; first += kAtOnce) {
        const int64_t count = std::min(kAtOnce, grid.nf - first);
        query.range(first, static_cast<size_t>(count), powers);
        const double *best = std::max_element(powers, powers + count);
        if (*best > highest) {
            highest = *best;
            top = first + (best - powers);
        }
    }
    highest = query.at(top); // as its neighbours, with which the peak is refined

    Peak peak = {};
    double shift = 0;
    peak.power = highest;
    peak.at_edge = top == 0 || top + 1 == grid.nf;
    // Where cosine and sine come to coincide, as at the Nyquist frequency of even times, the power jumps: no parabola.
    const auto smooth = [&](int64_t k) { return query.rank(k) == query.rank(top); };
    if (!peak.at_edge && smooth(top - 1) && smooth(top + 1)) {
        const double left = query.at(top - 1), right = query.at(top + 1), bend = left - 2 * highest + right;
        if (bend < 0) {
            shift = 0.5 * (left - right) / bend;
            peak.power = std::min(1.0, highest - 0.25 * (left - right) * shift);
        }
    }
    peak.grid_frequency = grid.f0 + grid.df * static_cast<double>(top);
    peak.frequency = grid.f0 + grid.df * (static_cast<double>(top) + shift);
    peak.log10_residual = std::log10(std::max(kLeastResidual, 1 - peak.power));
    const double half = peak.power / 2;
    peak.fwhm = half > 0 ? grid.df * (crossing(query, grid.nf, top, highest, 1, half) +
                                      crossing(query, grid.nf, top, highest, -1, half))
                         : std::numeric_limits<double>::infinity();
    peak.frequency_error = peak.amplitude = peak.amplitude_error = peak.phase = peak.offset = kUnknown;
    return peak;
}

} // namespace toliman::period
