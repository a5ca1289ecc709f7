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
    int64_t top = 0;
    double highest = query.at(0);
    for (int64_t k = 1; k < grid.nf; k++) {
        const double power = query.at(k);
        if (power > highest) {
            highest = power;
            top = k;
        }
    }

    Peak peak = {};
    double shift = 0;
    peak.power = highest;
    peak.at_edge = top == 0 || top + 1 == grid.nf;
    if (!peak.at_edge) {
        const double left = query.at(top - 1), right = query.at(top + 1), bend = left - 2 * highest + right;
        if (bend < 0)
            shift = 0.5 * (left - right) / bend; // good for the place: its height may exceed a clean sine's
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
