// Method: times are given from their weighted mean and values from their median, so that neither loses digits to a
// large offset; rows beyond the measurements are zeros, up to a multiple of the kernels' vector.
// Each source, the series and the velocities of each star, has a mean, Chebyshev polynomials
//     T_n(x) = cos(n arccos x),  x = ((t - start) - (end - t))/(end - start) in [-1, 1],
// and its columns as functions, which are 0 in the rows of the other sources.
// Measurements are divided by sqrt(sigma^2 + (jitter scale)^2), with the scale of their instrument (weights()).
// The axis: a separation measures the component of a displacement along the position angle theta of its frame. With the
// mean axis theta_0 = atan2(sum sin theta, sum cos theta), which has no jump at 360 deg, a displacement by p along it
// and q across it changes the separation by p cos(theta - theta_0) + q sin(theta - theta_0) (signal.cpp).
// Reference: Mardia and Jupp 2000, Directional Statistics, section 2.2 (mean direction).
#include "planet/series.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "base/robust.hpp"
#include "kernels/kepler_rows.hpp"

namespace toliman::planet {

namespace {

constexpr double kMostValue = 1e100;

void check(const GivenSeries &given, const char *name, const std::vector<double> &values) {
    for (size_t i = 0; i < values.size(); i++)
        if (!(std::fabs(values[i]) <= kMostValue))
            fail(Status::argument, "{%s}: %s[%zu] = %g: must be finite and at most 1e100", given.name.c_str(), name, i,
                 values[i]);
}

void check_sigmas(const GivenSeries &given) {
    for (size_t i = 0; i < given.sigma.size(); i++)
        if (!(given.sigma[i] >= 1e-100 && given.sigma[i] <= kMostValue))
            fail(Status::argument, "{%s}: sigma[%zu] = %g: must be in [1e-100, 1e100]", given.name.c_str(), i,
                 given.sigma[i]);
}

// Whether the numbers are finite, and enough.
void check(const GivenSeries &given) {
    check(given, "t", given.t);
    check(given, "y", given.y);
    check_sigmas(given);
    check(given, "rows", given.rows);
    const size_t needed = 7 + static_cast<size_t>(given.trend) + static_cast<size_t>(given.columns);
    if (given.n() < needed)
        fail(Status::state, "{%s}: n = %zu: must be at least %zu, the number of functions and 6", given.name.c_str(),
             given.n(), needed);
}

// Weighted mean; sigma empty: of equal weights.
double mean(const std::vector<double> &values, const std::vector<double> &sigma) {
    long double weight = 0, sum = 0;
    for (size_t i = 0; i < values.size(); i++) {
        const long double w = sigma.empty() ? 1 : 1 / (static_cast<long double>(sigma[i]) * sigma[i]);
        weight += w;
        sum += w * values[i];
    }
    return static_cast<double>(sum / weight);
}

void set_axis(const GivenSeries &given, Series &series) {
    constexpr double degree = kPi / 180;
    const std::vector<double> &angle = given.position_angle_deg;
    check(given, "position_angle_deg", angle);
    double cosine = 0, sine = 0;
    for (size_t i = 0; i < given.n(); i++) {
        cosine += std::cos(angle[i] * degree);
        sine += std::sin(angle[i] * degree);
    }
    series.axis = std::atan2(sine, cosine);
    series.axis_cosine.assign(series.rows, 0.0);
    series.axis_sine.assign(series.rows, 0.0);
    double least = 0, most = 0;
    for (size_t i = 0; i < given.n(); i++) {
        const double off = std::remainder(angle[i] * degree - series.axis, 2 * kPi);
        least = std::min(least, off);
        most = std::max(most, off);
        series.axis_cosine[i] = std::cos(off);
        series.axis_sine[i] = std::sin(off);
    }
    series.turn = most - least;
}

Function new_function(const Series &series, std::string name) {
    Function function;
    function.values.assign(series.rows, 0.0);
    function.name = std::move(name);
    return function;
}

// first: row of the first measurement, as for the next two.
void add_trend(const GivenSeries &given, size_t first, Series &series) {
    double start = given.trend_start, end = given.trend_end;
    if (start == 0 && end == 0 && given.n() > 0) {
        start = *std::min_element(given.t.begin(), given.t.end());
        end = *std::max_element(given.t.begin(), given.t.end());
    }
    if (given.trend > 0 && !(start < end))
        fail(Status::argument, "{%s}: trend_start = %.9g: must be below trend_end = %.9g", given.name.c_str(), start,
             end);
    for (int32_t order = 1; order <= given.trend; order++) {
        Function function = new_function(series, "T_" + std::to_string(order));
        for (size_t i = 0; i < given.n(); i++) {
            if (given.t[i] < start || given.t[i] > end)
                fail(Status::argument, "{%s}: t[%zu] = %.9g: outside the span of the trend, %.9g to %.9g",
                     given.name.c_str(), i, given.t[i], start, end);
            const double x = std::clamp(((given.t[i] - start) - (end - given.t[i])) / (end - start), -1.0, 1.0);
            function.values[first + i] = std::cos(order * std::acos(x));
        }
        series.functions.push_back(std::move(function));
    }
}

void add_columns(const GivenSeries &given, size_t first, Series &series) {
    const auto columns = static_cast<size_t>(given.columns);
    for (size_t j = 0; j < columns; j++) {
        Function function = new_function(series, "column " + std::to_string(j));
        for (size_t i = 0; i < given.n(); i++)
            function.values[first + i] = given.rows[i * columns + j];
        series.functions.push_back(std::move(function));
    }
}

// mean: index of the first function of these measurements.
void set_priors(const GivenSeries &given, size_t mean, Series &series) {
    for (size_t j = 0; j < series.functions.size() - mean; j++) {
        const double precision = given.precision[j];
        if (!(precision >= 0 && precision <= kMostValue))
            fail(Status::argument, "{%s}: prior_precision[%zu] = %g: must be in [0, 1e100]", given.name.c_str(), j,
                 precision);
        series.functions[mean + j].precision = precision;
    }
}

// mean: as for set_priors.
void add_groups(const GivenSeries &given, int32_t source, size_t first, size_t mean, Series &series) {
    const size_t before = series.groups.size(), column = mean + 1 + static_cast<size_t>(given.trend);
    for (size_t k = 0; k < given.offsets.size(); k++)
        series.groups.push_back({first, given.n(), static_cast<int32_t>(k), source, column + given.offsets[k]});
    for (size_t i = 0; i < given.n(); i++)
        series.group.push_back(
            static_cast<uint32_t>(before + (!given.instrument.empty() ? static_cast<size_t>(given.instrument[i]) : 0)));
}

} // namespace

Series::Series(const GivenSeries &given, const GivenVelocities &velocities)
    : n(given.n()), primary(given.n()), velocity(given.velocity) {
    check(given);
    bool has_motion = false;
    for (const std::optional<GivenSeries> &one : velocities.of)
        if (one) {
            check(*one);
            n += one->n();
            has_motion = true;
        }
    rows = (n + kernels::kRowLanes - 1) / kernels::kRowLanes * kernels::kRowLanes;
    time_reference = mean(given.t, given.sigma);
    t.assign(rows, 0.0);
    y.assign(rows, 0.0);
    sigma.assign(rows, 0.0);
    leave_out(std::vector<bool>(n));
    add(given, 0, 0);
    size_t first = given.n();
    for (int32_t star = 0; star < 2; star++) {
        if (has_motion)
            motion[star].assign(rows, 0.0);
        if (!velocities.of[star])
            continue;
        const GivenSeries &own = *velocities.of[star];
        add(own, 1 + star, first);
        std::fill_n(motion[star].begin() + static_cast<std::ptrdiff_t>(first), own.n(), velocities.per_motion[star]);
        first += own.n();
    }
    span = *std::max_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(n)) -
           *std::min_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(n));
    if (!(span > 0))
        fail(Status::argument, "{series}: all times are %.9g: must differ", given.t[0]);
    median_sigma = median(given.sigma);
    if (!given.position_angle_deg.empty())
        set_axis(given, *this);
    jitter_scales_.assign(groups.size(), 1.0);
}

// Adds measurements, from row `first` on, and their functions.
void Series::add(const GivenSeries &given, int32_t source, size_t first) {
    const double middle = median(given.y); // a mean is lost if one is 1e90
    for (size_t i = 0; i < given.n(); i++) {
        t[first + i] = given.t[i] - time_reference;
        y[first + i] = given.y[i] - middle;
        sigma[first + i] = given.sigma.empty() ? 0 : given.sigma[i];
    }
    const size_t at = functions.size();
    functions.push_back(new_function(*this, "mean"));
    std::fill_n(functions.back().values.begin() + static_cast<std::ptrdiff_t>(first), given.n(), 1.0);
    add_trend(given, first, *this);
    add_columns(given, first, *this);
    set_priors(given, at, *this);
    add_groups(given, source, first, at, *this);
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
        weights[i] = factor[i] > 0 ? factor[i] / std::hypot(sigma[i], jitter * jitter_scale(i)) : 0;
    return weights;
}

} // namespace toliman::planet
