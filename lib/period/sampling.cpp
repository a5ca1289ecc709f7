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
