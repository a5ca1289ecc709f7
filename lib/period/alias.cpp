// Method: the sampling repeats a sinusoid of frequency f at |f - g| and f + g with the power of the window function at
// g (Deeming 1975, Ap&SS 36, 137). The exact sums contain that function: C1 and S1 give it at the frequencies of the
// grid, C2 and S2 at twice these. So a state of sums names its aliases without the times, in any order, after a restart
// and after a merge.
// Choice of a peak: with frames every 3 d, a planet of 220 d has the same power at 3.04 d to the last digits, and noise
// decides which is higher: in 103 of 320 simulated missions with a scatter of the times from 0 to 0.8 d an alias was.
// Of a peak and its aliases, the one of the highest posterior probability with a prior that is uniform in the logarithm
// of the period is chosen: likelihood (1 - P)^(-n/2) of n degrees of freedom, over frequency. The true period was then
// chosen in all of these missions. Where the times scatter by 5 % of the interval or more, true short periods are also
// chosen. Rejected: a search up to 1/(2 median dt), which hides short periods and needs the times.
#include "period/alias.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "period/peak.hpp"
#include "period/sampling.hpp"

namespace toliman::period {

namespace {

constexpr double kSideLobes = 2.5;              // the window function within 2.5/T of 0 is the shape of each peak
constexpr double kNamed = 0.1;                  // least window function of an alias that is listed
constexpr double kParabola = 1e-3;              // largest error of a power interpolated between grid points 0.1/T apart
constexpr double kEvidence = 6.907755278982137; // ln 1000: samples with this likelihood ratio tell two peaks apart

double span_of(const Stream &stream) noexcept {
    return cadence_of(stream).span;
}

double frequency_of(const Grid &grid, int64_t k) noexcept {
    return grid.f0 + grid.df * static_cast<double>(k);
}

// The window function at f_k, or at 2 f_k, from the upper limbs of two sums.
double window_of(const Stream &stream, kernels::Sum cosine, kernels::Sum sine, int64_t k, double scale) noexcept {
    const double c = carry_save_value<double>(*stream.low(cosine, k), *stream.high(cosine, k)) * scale;
    const double s = carry_save_value<double>(*stream.low(sine, k), *stream.high(sine, k)) * scale;
    return c * c + s * s;
}

double scale_of(const Stream &stream) noexcept {
    return kUnit / static_cast<double>(stream.weight());
}

// At the nearest grid point; 0 where it is not known.
double known_window(const Stream &stream, double frequency) noexcept {
    const Grid &grid = stream.grid();
    const auto index = [&](double at) { return std::nearbyint((at - grid.f0) / grid.df); };
    const auto is_known = [&](double k) { return k >= 0 && k < static_cast<double>(grid.nf); };
    const double k = index(frequency), half = index(frequency / 2), scale = scale_of(stream);
    if (is_known(k))
        return window_of(stream, kernels::kC1, kernels::kS1, static_cast<int64_t>(k), scale);
    return is_known(half) ? window_of(stream, kernels::kC2, kernels::kS2, static_cast<int64_t>(half), scale) : 0;
}

// Calls visit(frequency, window) for the local maxima of the window function from `first` to `last` that are above
// `least`.
template <class Visit>
void each_window_peak(const Stream &stream, double first, double last, double least, Visit visit) {
    const Grid &grid = stream.grid();
    const double scale = scale_of(stream);
    double before = 1, here = 1, place = 0;
    const auto step = [&](double frequency, double value) {
        if (here > least && here >= before && here > value && place >= first)
            visit(place, here);
        before = here;
        here = value;
        place = frequency;
    };
    for (int64_t k = 0; k < grid.nf && place <= last; k++)
        step(frequency_of(grid, k), window_of(stream, kernels::kC1, kernels::kS1, k, scale));
    for (int64_t k = grid.nf / 2; k < grid.nf && place <= last; k++)
        if (2 * frequency_of(grid, k) > grid.last())
            step(2 * frequency_of(grid, k), window_of(stream, kernels::kC2, kernels::kS2, k, scale));
    step(std::numeric_limits<double>::infinity(), 0);
}

struct Top {
    int64_t k;
    double power; // of the parabola through three points
};

double vertex(const PowerQuery &query, const Grid &grid, int64_t k) noexcept {
    const double here = query.at(k);
    if (k == 0 || k + 1 == grid.nf || query.rank(k - 1) != query.rank(k) || query.rank(k + 1) != query.rank(k))
        return here;
    const double left = query.at(k - 1), right = query.at(k + 1), bend = left - 2 * here + right;
    return bend < 0 && here >= left && here >= right
               ? std::min(1.0, here - (left - right) * (left - right) / (8 * bend))
               : here;
}

// The highest power within 1/T of a frequency; k < 0 outside the grid.
Top highest_near(const PowerQuery &query, const Grid &grid, double frequency, double span) noexcept {
    const double k = std::nearbyint((frequency - grid.f0) / grid.df), reach = std::ceil(1 / (span * grid.df));
    const auto last = static_cast<double>(grid.nf - 1);
    if (!(k >= 0 && k <= last))
        return {-1, kUnknown};
    Top top = {-1, -1};
    for (auto i = static_cast<int64_t>(std::max(0.0, k - reach)); i <= static_cast<int64_t>(std::min(last, k + reach));
         i++)
        if (const double power = query.at(i); power > top.power)
            top = {i, power};
    top.power = vertex(query, grid, top.k);
    return top;
}

// ln of the likelihood of the power `better` over that of `worse`. Powers are interpolated.
double ln_likelihood_ratio(const Stream &stream, double better, double worse) noexcept {
    if (better - worse <= kParabola)
        return 0;
    const Sampling sampling = sampling_of(stream);
    return 0.5 * static_cast<double>(sampling.count - sampling.functions) *
           (std::log1p(-worse) - std::log(std::max(1e-15, 1 - better)));
}

// A frequency at which the window function is high.
struct Interval {
    Cause cause;
    double frequency, window;
    int parts = 1; // of the day
};

// Those that are named: the interval of the sampling, days and year.
class Intervals {
  public:
    explicit Intervals(const Stream &stream) : stream_(stream), span_(span_of(stream)) {
        const double day = 86400e9 / stream.grid().unit_ns;
        const Interval named[] = {{Cause::solar_day, 1 / day, 0},
                                  {Cause::sidereal_day, 1.00273790935 / day, 0},
                                  {Cause::year, 1 / (365.25 * day), 0}};
        for (Interval interval : named) {
            interval.window = highest(interval.frequency);
            add(interval);
        }
        add_sampling();
    }
    const Interval *begin() const noexcept { return found_; }
    const Interval *end() const noexcept { return found_ + count_; }
    // A frequency as a multiple of that of a day, otherwise as that of the sampling.
    Interval multiple(double frequency) const noexcept {
        const double high = window(stream_, frequency);
        for (const Interval &known : *this)
            if (known.cause != Cause::year && known.cause != Cause::sampling &&
                std::fabs(std::remainder(frequency, known.frequency)) * span_ < 1)
                return {known.cause, frequency, high, static_cast<int>(std::lround(frequency / known.frequency))};
        return {Cause::sampling, frequency, high};
    }

  private:
    // Within 0.2/T, since the window function is known at grid points.
    double highest(double frequency) const noexcept {
        double most = 0;
        for (int i = -2; i <= 2; i++)
            most = std::max(most, known_window(stream_, frequency + 0.1 * i / span_));
        return most;
    }
    // Of two that the time span does not resolve, the one of the higher window function.
    void add(const Interval &interval) noexcept {
        if (interval.window < kNamed)
            return;
        for (Interval *known = found_; known != found_ + count_; known++)
            if (std::fabs(known->frequency - interval.frequency) * span_ < 1) {
                if (known->window < interval.window && interval.cause != Cause::sampling)
                    *known = interval;
                return;
            }
        found_[count_++] = interval;
    }
    // The longest interval whose window function is nearly the highest.
    void add_sampling() {
        const double first = kSideLobes / span_, last = 2 * stream_.grid().last();
        double most = 0;
        each_window_peak(stream_, first, last, kNamed, [&](double, double height) { most = std::max(most, height); });
        if (most == 0)
            return;
        Interval sampling = {Cause::sampling, 0, 0};
        each_window_peak(stream_, first, last, 0.9 * most, [&](double frequency, double height) {
            if (sampling.window == 0)
                sampling = {Cause::sampling, frequency, height};
        });
        add(sampling);
    }

    const Stream &stream_;
    double span_;
    Interval found_[4];
    size_t count_ = 0;
};

} // namespace

double window(const Stream &stream, double gap) noexcept {
    return gap * span_of(stream) < kSideLobes ? 1 : known_window(stream, gap);
}

// Replaces the highest peak by an alias at a lower frequency if the likelihood loses no more than the prior, uniform in
// ln f and so proportional to 1/f, gains.
int64_t prefer_longest(const PowerQuery &query, const Stream &stream, int64_t highest) noexcept {
    const Grid &grid = stream.grid();
    const double span = span_of(stream), frequency = frequency_of(grid, highest);
    const double power = vertex(query, grid, highest);
    int64_t best = highest;
    each_window_peak(stream, kSideLobes / span, 2 * frequency, kRepeats, [&](double gap, double) {
        const double longer = std::fabs(frequency - gap);
        const Top top = highest_near(query, grid, longer, span);
        if (top.k >= 0 && top.k < best && frequency_of(grid, top.k) * span > 0.5 &&
            ln_likelihood_ratio(stream, power, top.power) <= std::log(frequency / frequency_of(grid, top.k)))
            best = top.k;
    });
    return best;
}

size_t find_aliases(const Stream &stream, double frequency, Alias *aliases) {
    const Grid &grid = stream.grid();
    const PowerQuery query(stream);
    check_meaningful(query, stream, "a peak");
    query.check();
    const double span = span_of(stream), power = highest_near(query, grid, frequency, span).power;
    size_t count = 0;
    const auto add = [&](const Interval &interval, double alias) {
        const bool is_slow = alias < grid.f0 && alias * span < kSideLobes;
        const double there = is_slow ? kUnknown : highest_near(query, grid, alias, span).power;
        const bool equal =
            std::isnan(there) ? interval.window >= kRepeats
                              : ln_likelihood_ratio(stream, std::max(power, there), std::min(power, there)) < kEvidence;
        aliases[count++] = {alias,          there,           interval.cause, 1 / interval.frequency,
                            interval.parts, interval.window, equal,          is_slow};
    };
    const Intervals intervals(stream);
    for (const Interval &interval : intervals) {
        add(interval, std::fabs(frequency - interval.frequency));
        add(interval, frequency + interval.frequency);
    }
    // The highest peak of the grid, where it is an alias by a multiple of these frequencies.
    const double highest = frequency_of(grid, highest_point(query, stream)), gap = std::fabs(highest - frequency);
    const double distance = window(stream, gap) >= window(stream, highest + frequency) ? gap : highest + frequency;
    const bool is_listed = std::any_of(
        aliases, aliases + count, [&](const Alias &alias) { return std::fabs(alias.frequency - highest) * span < 1; });
    if (gap * span >= kSideLobes && !is_listed && window(stream, distance) >= kNamed)
        add(intervals.multiple(distance), highest);
    std::stable_sort(aliases, aliases + count, [](const Alias &a, const Alias &b) { return a.window > b.window; });
    return count;
}

} // namespace toliman::period
