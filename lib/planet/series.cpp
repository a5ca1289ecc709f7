#include "planet/series.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "kernels/kepler_rows.hpp"

namespace toliman::planet {

namespace {

constexpr double kMostValue = 1e100;

void check(const char *name, const double *values, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!(std::fabs(values[i]) <= kMostValue))
            fail(Status::argument, "{series}: %s[%zu] = %g: must be finite and at most 1e100", name, i, values[i]);
}

void check_sigmas(const double *sigma, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!(sigma[i] >= 1e-100 && sigma[i] <= kMostValue))
            fail(Status::argument, "{series}: sigma[%zu] = %g: must be in [1e-100, 1e100]", i, sigma[i]);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Weighted mean, sigma NULL: of equal weights.
double mean(const double *values, const double *sigma, size_t n) {
    long double weight = 0, sum = 0;
    for (size_t i = 0; i < n; i++) {
        const long double w = sigma == nullptr ? 1 : 1 / (static_cast<long double>(sigma[i]) * sigma[i]);
        weight += w;
        sum += w * values[i];
    }
    return static_cast<double>(sum / weight);
}

void set_axis(const GivenSeries &given, Series &series) {
    const double *const angle = given.position_angle_deg, degree = kPi / 180;
    check("position_angle_deg", angle, given.n);
    double cosine = 0, sine = 0;
    for (size_t i = 0; i < given.n; i++) {
        cosine += std::cos(angle[i] * degree);
        sine += std::sin(angle[i] * degree);
    }
    series.axis = std::atan2(sine, cosine);
    series.axis_cosine.assign(series.rows, 0.0);
    series.axis_sine.assign(series.rows, 0.0);
    double least = 0, most = 0;
    for (size_t i = 0; i < given.n; i++) {
        const double off = std::remainder(angle[i] * degree - series.axis, 2 * kPi);
        least = std::min(least, off);
        most = std::max(most, off);
        series.axis_cosine[i] = std::cos(off);
        series.axis_sine[i] = std::sin(off);
    }
    series.turn = most - least;
}

void add_trend(const GivenSeries &given, Series &series) {
    double start = given.trend_start, end = given.trend_end;
    if (start == 0 && end == 0 && given.n > 0) {
        start = *std::min_element(given.t, given.t + given.n);
        end = *std::max_element(given.t, given.t + given.n);
    }
    if (given.trend > 0 && !(start < end))
        fail(Status::argument, "{series}: trend_start = %.9g: must be below trend_end = %.9g", start, end);
    for (int32_t order = 1; order <= given.trend; order++) {
        Function function;
        function.values.assign(series.rows, 0.0);
        for (size_t i = 0; i < given.n; i++) {
            if (given.t[i] < start || given.t[i] > end)
                fail(Status::argument, "{series}: t[%zu] = %.9g: outside the span of the trend, %.9g to %.9g", i,
                     given.t[i], start, end);
            const double x = std::clamp(((given.t[i] - start) - (end - given.t[i])) / (end - start), -1.0, 1.0);
            function.values[i] = std::cos(order * std::acos(x));
        }
        series.functions.push_back(std::move(function));
    }
}

void add_columns(const GivenSeries &given, Series &series) {
    const auto columns = static_cast<size_t>(given.columns);
    for (size_t j = 0; j < columns; j++) {
        Function function;
        function.values.assign(series.rows, 0.0);
        for (size_t i = 0; i < given.n; i++)
            function.values[i] = given.rows[i * columns + j];
        series.functions.push_back(std::move(function));
    }
}

void set_priors(const GivenSeries &given, Series &series) {
    for (size_t j = 0; j < series.functions.size(); j++) {
        const double precision = given.precision[j];
        if (!(precision >= 0 && precision <= kMostValue))
            fail(Status::argument, "{series}: prior_precision[%zu] = %g: must be in [0, 1e100]", j, precision);
        series.functions[j].precision = precision;
    }
}

} // namespace

Series::Series(const GivenSeries &given) : n(given.n), velocity(given.velocity) {
    check("t", given.t, n);
    check("y", given.y, n);
    if (given.sigma != nullptr)
        check_sigmas(given.sigma, n);
    check("rows", given.rows, n * static_cast<size_t>(given.columns));
    const size_t needed = 7 + static_cast<size_t>(given.trend) + static_cast<size_t>(given.columns);
    if (n < needed)
        fail(Status::state, "{series}: n = %zu: must be at least %zu, the number of functions and 6", n, needed);
    rows = (n + kernels::kRowLanes - 1) / kernels::kRowLanes * kernels::kRowLanes;
    time_reference = mean(given.t, given.sigma, n);
    trend = static_cast<size_t>(given.trend);
    const double middle = n > 0 ? median({given.y, given.y + n}) : 0; // a mean is lost if one value is 1e90
    t.assign(rows, 0.0);
    y.assign(rows, 0.0);
    sigma.assign(rows, 0.0);
    leave_out(std::vector<bool>(n));
    for (size_t i = 0; i < n; i++) {
        t[i] = given.t[i] - time_reference;
        y[i] = given.y[i] - middle;
        sigma[i] = given.sigma != nullptr ? given.sigma[i] : 0;
    }
    span = *std::max_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(n)) -
           *std::min_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(n));
    if (!(span > 0))
        fail(Status::argument, "{series}: all times are %.9g: must differ", given.t[0]);
    median_sigma = given.sigma != nullptr ? median({given.sigma, given.sigma + n}) : 0;
    if (given.position_angle_deg != nullptr)
        set_axis(given, *this);
    Function one;
    one.values.assign(rows, 1.0);
    functions.push_back(std::move(one));
    add_trend(given, *this);
    add_columns(given, *this);
    set_priors(given, *this);
}

void Series::leave_out(const std::vector<bool> &marked) {
    factor.assign(rows, 0.0);
    used = 0;
    for (size_t i = 0; i < n; i++)
        if (!marked[i]) {
            factor[i] = 1;
            used++;
        }
}

Buffer<double> Series::weights(double jitter) const {
    Buffer<double> weights(rows, 0.0);
    for (size_t i = 0; i < n; i++)
        weights[i] = factor[i] > 0 ? factor[i] / std::hypot(sigma[i], jitter) : 0;
    return weights;
}

} // namespace toliman::planet
