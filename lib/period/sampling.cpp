// Method: sums know the variance of the times and not the times. Times that cover a span T evenly have var t = T^2/12,
// and N times dt apart var t = dt^2 (N^2 - 1)/12: T, and the exact step, follow.
// With the times, the finest step is the median of gap/round(gap/g) over the gaps, where g is the gap that 5 % of them
// do not exceed. The sampling is regular if the mean of cos(2 pi r/step) is at least 0.95, r being the distance of a
// gap from the nearest multiple of the step. The spectrum of regular samples repeats above 1/(2 step) (Eyer and
// Bartholdi 1999, A&AS 135, 1). That of others does not (VanderPlas 2018, ApJS 236, 16, section 4): up to five times
// 1/(2 g) is worth a search.
#include "period/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "period/stream/projection.hpp"

namespace toliman::period {

Sampling sampling_of(const Stream &stream) noexcept {
    const int64_t free = stream.grid().basis.any() ? static_cast<int64_t>(Projection(stream).free()) : 1;
    return {stream.totals().count, stream.grid().last(), static_cast<double>(stream.time_variance()), free};
}

Cadence cadence_of(const Stream &stream) noexcept {
    return cadence_of(sampling_of(stream));
}

Cadence cadence_of(const Sampling &sampling) noexcept {
    if (sampling.count == 0)
        return {0, 0, 0};
    const double span = baseline(sampling.time_variance), step = span / static_cast<double>(sampling.count);
    return {span, step, step};
}

double even_step(const Stream &stream) noexcept {
    const auto n = static_cast<long double>(stream.totals().count);
    return n > 1 ? static_cast<double>(std::sqrt(12 * stream.time_variance() / (n * n - 1))) : 0;
}

Cadence cadence_of(const Stream &stream, const double *t, size_t count) {
    if (static_cast<int64_t>(count) != stream.totals().count)
        fail(Status::argument, "{n} = %zu: must be the number of samples pushed, %lld", count,
             static_cast<long long>(stream.totals().count));
    for (size_t i = 0; i < count; i++)
        if (!std::isfinite(t[i]))
            fail(Status::argument, "sample %zu: {t} = %g: must be finite", i, t[i]);
    return cadence_of({t, t + count});
}

Cadence cadence_of(std::vector<double> times) {
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    if (times.size() < 2)
        return {0, 0, 0};
    const double span = times.back() - times.front();
    std::adjacent_difference(times.begin(), times.end(), times.begin());
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>((times.size() + 1) / 2);
    std::nth_element(times.begin() + 1, middle, times.end());
    const double step = *middle;
    times.erase(times.begin());
    return {span + step, step, finest_step(std::move(times))};
}

double finest_step(std::vector<double> gaps) {
    constexpr double kShare = 0.05, kRegular = 0.95, kFinest = 5; // cos of 5 % of a cycle; as astropy's nyquist_factor
    const auto nth = [](std::vector<double> &values, double share) {
        const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), place, values.end());
        return *place;
    };
    const double shortest = nth(gaps, kShare);
    std::vector<double> steps;
    for (const double gap : gaps)
        steps.push_back(gap / std::fmax(1, std::nearbyint(gap / shortest)));
    const double step = nth(steps, 0.5);
    double sum = 0;
    for (const double gap : gaps)
        sum += std::cos(2 * kPi * std::remainder(gap, step) / step);
    return sum >= kRegular * static_cast<double>(gaps.size()) ? step : shortest / kFinest;
}

} // namespace toliman::period
