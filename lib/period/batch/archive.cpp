// Method: one compensated pass each for the mean time, the mean value and the variance. Times are differences from a
// sample's time and values differences from the first value, as error-free pairs, so that large offsets (a Julian date,
// a mean of 1e9) lose no digits and equal values give exactly 0. Scaling by powers of two is exact and avoids overflow.
#include "period/batch/archive.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace toliman::period {

namespace {

constexpr double kMaxValue = 1e300, kMaxCycles = 0x1p50;

struct Pair {
    double high, low; // an unevaluated sum
};

Pair difference(double a, double b) noexcept {
    const double high = a - b, back = high - a;
    return {high, (a - (high - back)) - (b + back)};
}

// Compensated sum (Knuth's TwoSum).
struct Compensated {
    double high = 0, low = 0;
    void add(double x) noexcept {
        const double sum = high + x, back = sum - high;
        low += (high - (sum - back)) + (x - back);
        high = sum;
    }
    void add_product(double a, double b) noexcept {
        const double product = a * b;
        add(product);
        low += std::fma(a, b, -product);
    }
    long double value() const noexcept { return static_cast<long double>(high) + low; }
};

void check(const BatchSamples &samples, size_t i) {
    const double t = samples.t[i], y = samples.y[i];
    if (!std::isfinite(t))
        fail(Status::argument, "sample %zu: {t} = %g: must be finite", i, t);
    if (!std::isfinite(y))
        fail(Status::argument, "sample %zu: {y} = %g: must be finite", i, y);
    if (samples.sigma != nullptr && !(std::isfinite(samples.sigma[i]) && samples.sigma[i] > 0))
        fail(Status::argument, "sample %zu: {sigma} = %g: must be finite and above 0", i, samples.sigma[i]);
    if (!(std::fabs(t) <= kMaxTime))
        fail(Status::range, "sample %zu: {t} = %g: must be in [-%g, %g]", i, t, kMaxTime, kMaxTime);
    if (!(std::fabs(y) <= kMaxValue))
        fail(Status::range, "sample %zu: {y} = %g: must be in [-%g, %g]", i, y, kMaxValue, kMaxValue);
}

// 2^e with |largest| 2^e in [1/2, 1).
double power_of_two(double largest) noexcept {
    int exponent = 0;
    std::frexp(largest, &exponent);
    return std::ldexp(1.0, std::min(-exponent, 1000));
}

} // namespace

Archive::Archive(const BatchSamples &given, double last) : samples(given), n(given.n) {
    checked_product(n, 4 * sizeof(double), "samples");
    if (n == 0)
        return;
    for (size_t i = 0; i < n; i++)
        check(samples, i);
    t_high.resize(n);
    t_low.resize(n);
    w.resize(n);
    const double *sigma = samples.sigma, first_time = samples.t[0];
    if (sigma != nullptr) {
        least_sigma = *std::min_element(sigma, sigma + n);
        most_sigma = *std::max_element(sigma, sigma + n);
        sigma_scale = power_of_two(least_sigma);
    }
    first_value = samples.y[0];
    Compensated weight, time;
    for (size_t i = 0; i < n; i++) {
        const double ratio = sigma != nullptr ? least_sigma / sigma[i] : 1;
        w[i] = ratio * ratio;
        weight.add(w[i]);
        time.add_product(w[i], samples.t[i] - first_time);
        value_bound = std::max(value_bound, std::fabs(samples.y[i] - first_value));
    }
    const long double part = 1 / weight.value();
    unit_variance = static_cast<double>(part) * least_sigma * least_sigma;
    const auto mean_time = static_cast<double>(first_time + time.value() * part);
    reference = *std::min_element(samples.t, samples.t + n, [&](double a, double b) {
        return std::fabs(a - mean_time) < std::fabs(b - mean_time);
    });
    for (size_t i = 0; i < n; i++) {
        w[i] = static_cast<double>(w[i] * part);
        const Pair t = difference(samples.t[i], reference);
        t_high[i] = t.high;
        t_low[i] = t.low;
        if (!(std::fabs(t.high) * last <= kMaxCycles))
            fail(Status::range, "sample %zu: {t} = %g: must be within 2^50 cycles of the mean time", i, samples.t[i]);
    }
    if (value_bound == 0)
        return;
    // Values about the mean. The mean is that of the differences from the first value: equal values give exactly 0.
    value_scale = power_of_two(value_bound);
    const auto value = [&](size_t i) {
        const Pair gap = difference(samples.y[i], first_value);
        return Pair{gap.high * value_scale, gap.low * value_scale};
    };
    Compensated sum, square, least;
    for (size_t i = 0; i < n; i++) {
        const Pair v = value(i);
        sum.add_product(w[i], v.high);
        sum.low += w[i] * v.low;
        least.add(w[i]);
    }
    const long double mean = sum.value() / least.value();
    const auto mean_high = static_cast<double>(mean), mean_low = static_cast<double>(mean - mean_high);
    x.resize(n);
    for (size_t i = 0; i < n; i++) {
        const Pair v = value(i), gap = difference(v.high, mean_high);
        x[i] = gap.high + (gap.low + (v.low - mean_low));
        square.add(w[i] * x[i] * x[i]);
    }
    if (!(square.value() > 0)) { // samples that differ from the mean have negligible weight: their terms underflow
        x.clear();
        return;
    }
    const auto per_deviation = static_cast<double>(1 / std::sqrt(square.value()));
    mean_in_deviations = (first_value * value_scale + mean_high) * per_deviation;
    for (size_t i = 0; i < n; i++) {
        x[i] *= w[i] * per_deviation;
        largest_sum += std::fabs(x[i]);
    }
}

} // namespace toliman::period
