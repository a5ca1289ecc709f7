// Method: the highest grid point; its frequency is the vertex of the parabola through it and its two neighbours, its
// width the distance of the half-power points by linear interpolation between grid points. Power and FAP stay those of
// the grid point: the vertex of a parabola can exceed the power that a pure sinusoid has, and would understate the FAP.
// Of a peak and its aliases the most probable one is chosen (alias.cpp). A peak counts as an alias of a higher one if
// that could produce half of its power or more.
#include "period/peak.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/power.hpp"
#include "period/alias.hpp"
#include "period/stream/power.hpp"

namespace toliman::period {

namespace {

constexpr double kMinResidual = 1e-15; // 1 - power from the sums carries no more digits

// Distance in grid steps from `top`, whose power is `here`, to where the power falls to `threshold` in `direction`
// (+-1).
double crossing(const PowerQuery &query, int64_t nf, int64_t top, double here, int direction,
                double threshold) noexcept {
    for (int64_t k = top + direction; k >= 0 && k < nf; k += direction) {
        const double next = query.at(k);
        if (next <= threshold)
            return static_cast<double>((k - top) * direction - 1) + (here - threshold) / (here - next);
        here = next;
    }
    return std::numeric_limits<double>::infinity();
}

bool any_reaches(const double *powers, int64_t count, double limit) noexcept {
    return kernels::power_kernels().any_reaches(powers, static_cast<size_t>(count), limit);
}

// Calls work(first, powers, count) for the frequencies of the grid, in order, some at a time.
template <class Work> void each_range(const PowerQuery &query, int64_t nf, Work work) {
    constexpr int64_t kAtOnce = 512;
    double powers[kAtOnce];
    for (int64_t first = 0; first < nf; first += kAtOnce) {
        const int64_t count = std::min(kAtOnce, nf - first);
        query.range(first, static_cast<size_t>(count), powers);
        if (any_reaches(powers, count, 1))
            for (int64_t i = 0; i < count; i++)
                query.check_power(first + i, powers[i]);
        work(first, powers, count);
    }
}

// The peak at grid point `top`, refined by a parabola through its neighbours.
Peak refined(const PowerQuery &query, const Grid &grid, int64_t top) noexcept {
    const double highest = query.at(top);
    Peak peak = {};
    double shift = 0;
    peak.power = highest;
    peak.at_edge = top == 0 || top + 1 == grid.nf;
    // Where the rank changes, as at the Nyquist frequency of evenly spaced times, the power is discontinuous: no
    // parabola.
    const auto smooth = [&](int64_t k) { return query.rank(k) == query.rank(top); };
    if (!peak.at_edge && smooth(top - 1) && smooth(top + 1)) {
        const double left = query.at(top - 1), right = query.at(top + 1), bend = left - 2 * highest + right;
        if (bend < 0) // only the place of the vertex is used
            shift = std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
    }
    peak.inaccurate = query.inaccurate(top);
    peak.grid_frequency = grid.f0 + grid.df * static_cast<double>(top);
    peak.frequency = grid.f0 + grid.df * (static_cast<double>(top) + shift);
    peak.log10_residual = std::log10(std::max(kMinResidual, 1 - peak.power));
    const double half = peak.power / 2;
    peak.fwhm = half > 0 ? grid.df * (crossing(query, grid.nf, top, highest, 1, half) +
                                      crossing(query, grid.nf, top, highest, -1, half))
                         : std::numeric_limits<double>::infinity();
    peak.frequency_error = peak.amplitude = peak.amplitude_error = peak.phase = peak.offset = kUnknown;
    return peak;
}

// Returns whether the sampling alone could produce half of a peak's power or more from a higher peak.
bool is_alias(const Stream &stream, const Peak &higher, const Peak &peak) noexcept {
    const double gap = std::fabs(peak.frequency - higher.frequency), sum = peak.frequency + higher.frequency;
    return std::max(window(stream, gap), window(stream, sum)) * higher.power >= peak.power / 2;
}

} // namespace

Sample sample_of(const Stream &stream, const Samples &samples, size_t i) noexcept {
    const double sigma = samples.sigma != nullptr ? samples.sigma[i] : stream.grid().sigma_floor;
    Sample sample = stream.sample(samples.t[i], 0, samples.y[i], sigma);
    if (samples.columns != nullptr)
        sample.columns = samples.columns + i * static_cast<size_t>(stream.grid().basis.columns);
    return sample;
}

void check_pushed(const Stream &stream, const Samples &samples) {
    if (static_cast<int64_t>(samples.count) != stream.totals().count)
        fail(Status::argument, "{n} = %zu: must be the number of samples pushed, %lld", samples.count,
             static_cast<long long>(stream.totals().count));
    for (size_t i = 0; i < samples.count; i++)
        stream.check(sample_of(stream, samples, i), static_cast<int64_t>(i));
}

void check_meaningful(const PowerQuery &query, const Stream &stream, const char *what) {
    const auto count = static_cast<long long>(stream.totals().count),
               least = static_cast<long long>(query.least_samples());
    if (query.meaningful())
        return;
    if (stream.grid().basis.any())
        fail(Status::state,
             "%s needs at least %lld samples, four more than functions without a prior, whose values the nuisance "
             "functions alone do not describe: %lld were pushed",
             what, least, count);
    if (count < least)
        fail(Status::state, "%s needs at least five samples that are not all equal: %lld were pushed", what, count);
    fail(Status::state,
         "%s needs samples that are not all equal: the values of the %lld samples pushed are equal, or differ by less "
         "than value_bound = %g resolves (its minimum is 1e-100: scale smaller values up)",
         what, count, stream.grid().value_bound);
}

int64_t highest_point(const PowerQuery &query, const Stream &stream) {
    int64_t top = 0;
    double highest = -1;
    each_range(query, stream.grid().nf, [&](int64_t first, const double *powers, int64_t count) {
        if (!any_reaches(powers, count, highest))
            return;
        const double *const most = std::max_element(powers, powers + count);
        if (*most > highest) {
            highest = *most;
            top = first + (most - powers);
        }
    });
    return top;
}

Peak find_peak(const Stream &stream) {
    const PowerQuery query(stream);
    check_meaningful(query, stream, "a peak");
    query.check();
    return refined(query, stream.grid(), prefer_longest(query, stream, highest_point(query, stream)));
}

double highest_log10_residual(const Stream &stream) {
    const PowerQuery query(stream);
    return refined(query, stream.grid(), highest_point(query, stream)).log10_residual;
}

namespace {

// Moves the peak to the front; if it is not among them, it replaces the last.
void put_first(const Peak &peak, Peak *peaks, size_t count) {
    Peak *const last = peaks + count;
    Peak *place =
        std::find_if(peaks, last, [&](const Peak &other) { return other.grid_frequency == peak.grid_frequency; });
    if (place == last)
        *--place = peak;
    std::rotate(peaks, place, place + 1);
}

} // namespace

size_t find_peaks(const Stream &stream, size_t most, Peak *peaks) {
    const PowerQuery query(stream);
    check_meaningful(query, stream, "a peak");
    query.check();
    struct Top {
        int64_t k;
        double power;
    } tops[kMaxPeaks];
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
    each_range(query, nf, [&](int64_t first, const double *powers, int64_t some) {
        for (int64_t i = 0; i < some; i++) {
            if (first + i > 0 && here > before && here >= powers[i])
                keep(first + i - 1, here);
            before = here;
            here = powers[i];
        }
    });
    if (here > before)
        keep(nf - 1, here);
    for (size_t i = 0; i < count; i++)
        peaks[i] = refined(query, stream.grid(), tops[i].k);
    std::sort(peaks, peaks + count, [](const Peak &a, const Peak &b) { return a.power > b.power; });
    put_first(refined(query, stream.grid(), prefer_longest(query, stream, highest_point(query, stream))), peaks, count);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i && !peaks[i].alias; j++)
            peaks[i].alias = is_alias(stream, peaks[j], peaks[i]);
    return count;
}

} // namespace toliman::period
