#include "period/peak.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "period/power.hpp"

namespace toliman::period {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastResidual = 1e-15; // 1 - power from the sums carries no more digits

// Frequency, in grid steps from `top`, where the power falls through `level` on the side of `direction`.
double crossing(const std::vector<double> &power, int64_t top, int direction, double level) noexcept {
    const auto size = static_cast<int64_t>(power.size());
    for (int64_t k = top; k + direction >= 0 && k + direction < size; k += direction) {
        const double here = power[static_cast<size_t>(k)], next = power[static_cast<size_t>(k + direction)];
        if (next <= level)
            return static_cast<double>(k - top) * direction + (here - level) / (here - next);
    }
    return kUnknown;
}

} // namespace

Peak find_peak(const Stream &stream) {
    const PowerQuery query(stream);
    if (!query.meaningful())
        fail(Status::state, "a peak needs at least five samples that are not all equal; %lld were pushed",
             static_cast<long long>(stream.totals().count));
    const Grid &grid = stream.grid();
    std::vector<double> power(static_cast<size_t>(grid.nf));
    for (size_t k = 0; k < power.size(); k++)
        power[k] = query.at(static_cast<int64_t>(k));
    const auto highest = std::max_element(power.begin(), power.end());
    const int64_t top = highest - power.begin();

    Peak peak = {};
    double shift = 0;
    peak.power = *highest;
    if (top > 0 && top + 1 < grid.nf) {
        const double left = highest[-1], right = highest[1], bend = left - 2 * *highest + right;
        if (bend < 0) {
            shift = 0.5 * (left - right) / bend;
            peak.power = std::min(1.0, *highest - 0.25 * (left - right) * shift);
        }
    }
    peak.frequency = grid.f0 + grid.df * (static_cast<double>(top) + shift);
    peak.log10_residual = std::log10(std::max(kLeastResidual, 1 - peak.power));
    const double half = peak.power / 2;
    peak.fwhm = grid.df * (crossing(power, top, 1, half) + crossing(power, top, -1, half));
    peak.frequency_error = peak.amplitude = peak.amplitude_error = peak.phase = peak.offset = kUnknown;
    return peak;
}

} // namespace toliman::period
