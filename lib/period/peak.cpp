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

// Powers of the whole grid, a few at a time: work(k, power).
template <class Work> void each_power(const PowerQuery &query, int64_t nf, Work work) {
    constexpr int64_t kAtOnce = 512;
    double powers[kAtOnce];
    for (int64_t first = 0; first < nf; first += kAtOnce) {
        const int64_t count = std::min(kAtOnce, nf - first);
        query.range(first, static_cast<size_t>(count), powers);
        for (int64_t i = 0; i < count; i++) {
            query.check_power(first + i, powers[i]);
            work(first + i, powers[i]);
        }
    }
}

// The peak at grid point `top`, refined by a parabola through its neighbours.
Peak refined(const PowerQuery &query, const Grid &grid, int64_t top) noexcept {
    const double highest = query.at(top);
    Peak peak = {};
    double shift = 0;
    peak.power = highest;
    peak.at_edge = top == 0 || top + 1 == grid.nf;
    // Where cosine and sine come to coincide, as at the Nyquist frequency of even times, the power jumps: no parabola.
    const auto smooth = [&](int64_t k) { return query.rank(k) == query.rank(top); };
    if (!peak.at_edge && smooth(top - 1) && smooth(top + 1)) {
        const double left = query.at(top - 1), right = query.at(top + 1), bend = left - 2 * highest + right;
        if (bend < 0) // good for the place: its height may exceed a clean sine's
            shift = std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
    }
    peak.inaccurate = query.inaccurate(top);
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

void check_meaningful(const PowerQuery &query, const Stream &stream) {
    const auto count = static_cast<long long>(stream.totals().count);
    if (!query.meaningful() && count < 5)
        fail(Status::state, "a peak needs at least five samples that are not all equal; %lld were pushed", count);
    if (!query.meaningful())
        fail(
            Status::state,
            "a peak needs samples that are not all equal: the values of the %lld that were pushed are equal, or differ "
            "by less than value_bound = %g resolves (it is at least 1e-100: scale values below that)",
            count, stream.grid().value_bound);
    query.check();
}

// Part of a sinusoid's power that the sampling repeats `gap` away: the window function, where the grid has that
// frequency. Below the grid it is 1 within the width of a peak.
double window(const Stream &stream, double gap) noexcept {
    const Grid &grid = stream.grid();
    const double span = std::sqrt(12 * static_cast<double>(stream.time_variance())); // of evenly spread times
    if (gap * span < 2.5)
        return 1;
    const double k = std::nearbyint((gap - grid.f0) / grid.df);
    if (!(k >= 0 && k < static_cast<double>(grid.nf)))
        return 0;
    const SumsAt<long double> sums = stream.sums<long double>(static_cast<int64_t>(k));
    const auto weight = static_cast<long double>(stream.weight());
    return static_cast<double>((sums.c1 * sums.c1 + sums.s1 * sums.s1) / (weight * weight));
}

// Whether the sampling alone could make half of a peak's power or more from a higher one.
bool is_alias(const Stream &stream, const Peak &higher, const Peak &peak) noexcept {
    const double gap = std::fabs(peak.frequency - higher.frequency), sum = peak.frequency + higher.frequency;
    return std::max(window(stream, gap), window(stream, sum)) * higher.power >= peak.power / 2;
}

} // namespace

Peak find_peak(const Stream &stream) {
    const PowerQuery query(stream);
    check_meaningful(query, stream);
    int64_t top = 0;
    double highest = -1;
    each_power(query, stream.grid().nf, [&](int64_t k, double power) {
        if (power > highest) {
            highest = power;
            top = k;
        }
    });
    return refined(query, stream.grid(), top);
}

size_t find_peaks(const Stream &stream, size_t most, Peak *peaks) {
    const PowerQuery query(stream);
    check_meaningful(query, stream);
    struct Top {
        int64_t k;
        double power;
    } tops[kMostPeaks];
    size_t count = 0;
    const auto keep = [&](int64_t k, double power) {
        size_t at = count;
        for (; at > 0 && tops[at - 1].power < power; at--)
            if (at < most)
                tops[at] = tops[at - 1];
        if (at < most)
            tops[at] = {k, power};
        count = std::min(count + (at < most || count < most ? 1 : 0), most);
    };
    double before = -1, here = -1;
    const int64_t nf = stream.grid().nf;
    each_power(query, nf, [&](int64_t k, double power) {
        if (k > 0 && here > before && here >= power)
            keep(k - 1, here);
        before = here;
        here = power;
    });
    if (here > before)
        keep(nf - 1, here);
    for (size_t i = 0; i < count; i++)
        peaks[i] = refined(query, stream.grid(), tops[i].k);
    std::sort(peaks, peaks + count, [](const Peak &a, const Peak &b) { return a.power > b.power; });
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i && !peaks[i].alias; j++)
            peaks[i].alias = is_alias(stream, peaks[j], peaks[i]);
    return count;
}

} // namespace toliman::period
