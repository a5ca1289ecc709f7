// Method: reduced = measured/factor - geometric (sky/reduction.cpp). What the errors of the elements change is fitted
// with the mean, by the partial derivatives as columns with the standard deviations of the elements as priors; without
// priors or sigmas, by a polynomial in time instead, of an order that leaves 0.06 uas of the errors of the orbit of
// alpha Centauri (median).
#include "measure/reduction.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.hpp"
#include "base/robust.hpp"
#include "sky/columns.hpp"

namespace toliman::measure {

namespace {

constexpr int32_t kOrbitTrend = 4;

struct Unit {
    double factor;
    const char *name;
};

// The median of the ratios of measured and predicted separations is not far from 1, or the unit is another one.
void check_unit(std::vector<double> ratios) {
    constexpr double kMost = 2; // an orbit wrong by more is not that of the stars
    constexpr Unit kUnits[] = {
        {1e6, "uas"}, {1e3, "mas"}, {1 / 60.0, "arcmin"}, {1 / 3600.0, "deg"}, {1 / 206264.806, "rad"}};
    const double middle = median(std::move(ratios));
    if (middle >= 1 / kMost && middle <= kMost)
        return;
    const auto found = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit &unit) {
        return middle > unit.factor / kMost && middle < unit.factor * kMost;
    });
    fail(Status::argument, "{y}: median %.4g times the predicted separations: must be in arcsec; are they in %s?",
         middle, found != std::end(kUnits) ? found->name : "px, or those of another system");
}

void check_measured(const Series &measured) {
    if (measured.kind != Kind::separation)
        fail(Status::argument,
             "{measured}: its kind must be TOLIMAN_MEASURE_SEPARATION: separations as they were measured");
    if (measured.count() == 0)
        fail(Status::argument, "{measured}: has no samples");
    if (!(measured.unit > 0))
        fail(Status::argument, "{measured}: its unit is not known: must be arcsec per unit of its values");
    if (measured.exposures.empty())
        fail(Status::argument, "{measured}: its exposures are not known: must have intervals, or dates and exposure_s");
}

std::vector<sky::Reduced> reduced_of(const Series &measured, const sky::Predictor &predictor) {
    std::vector<sky::Reduced> reduced;
    reduced.reserve(measured.count());
    for (size_t i = 0; i < measured.count(); i++) {
        try {
            reduced.push_back(sky::reduce(predictor, measured.exposures[i], measured.y[i] * measured.unit));
        } catch (const Error &error) {
            fail_within(error, error.status(), "measurement %zu: %s", i, error.what());
        }
    }
    return reduced;
}

// Columns of the errors of the elements, in units of the series.
void add_columns(const std::vector<sky::Prediction> &seen, const std::vector<sky::Column> &errors, Series &series) {
    for (const sky::Column &error : errors) {
        const double sigma = error.sigma / series.unit;
        Column column = {sky::element_name(error.element), {}, error.bound, 1 / (sigma * sigma), series.unit};
        for (const sky::Prediction &prediction : seen)
            column.values.push_back(prediction.partials[error.element]);
        series.columns.push_back(std::move(column));
    }
}

std::string add_functions(const std::vector<sky::Prediction> &seen, const sky::Predictor &predictor, double scale_sigma,
                          Series &series) {
    const std::string why = series.sigma.empty() ? "the series has no sigma"
                            : sky::error_columns(predictor.system(), 0).empty()
                                ? "the system has no standard deviations of its elements"
                                : "";
    if (why.empty()) {
        add_columns(seen, sky::error_columns(predictor.system(), scale_sigma), series);
        return "";
    }
    const auto [first, last] = std::minmax_element(series.t.begin(), series.t.end());
    if (!(*first < *last))
        return why + ": nothing is fitted in place of the errors of the orbit, as all times are equal";
    series.set_trend(kOrbitTrend, 0, 0);
    return why + ": a trend of order " + std::to_string(kOrbitTrend) + " is fitted in place of the errors of the orbit";
}

} // namespace

void set_stars(const sky::System &system, const std::vector<int64_t> &tai_ns, Series &series) {
    series.is_refitted = !tai_ns.empty() && sky::is_refitted_to(system, sky::dates_of(tai_ns));
    series.parallax_arcsec = system.value.barycentre.parallax_mas / 1000;
    series.star_mass[0] = system.value.masses.a_sun;
    series.star_mass[1] = system.value.masses.b_sun;
}

Reduction reduce(const Series &measured, const sky::Predictor &predictor, double scale_sigma, bool with_functions) {
    check_measured(measured);
    const std::vector<sky::Reduced> all = reduced_of(measured, predictor);
    Series series = measured;
    for (std::vector<double> *values : {&series.t, &series.y, &series.sigma, &series.position_angle_deg})
        values->clear();
    series.exposures.clear();
    series.tai_ns.clear();
    series.instrument.clear();
    for (Column &column : series.columns)
        column.values.clear();
    series.kind = Kind::reduced;
    std::vector<sky::Prediction> seen;
    std::vector<double> angles, ratios;
    std::vector<int64_t> starts;
    for (size_t i = 0; i < all.size(); i++) {
        const sky::Prediction &prediction = all[i].seen;
        if (std::isnan(prediction.factor)) {
            series.left_out++;
            continue;
        }
        const double measured_arcsec = measured.y[i] * measured.unit;
        series.add(measured, i);
        series.y.back() = all[i].separation_arcsec / measured.unit;
        if (!series.sigma.empty())
            series.sigma.back() /= prediction.factor;
        series.separation_arcsec.push_back(measured_arcsec);
        series.factor.push_back(prediction.factor);
        series.geometric_arcsec.push_back(prediction.geometric_arcsec);
        angles.push_back(prediction.geometric_angle_deg);
        ratios.push_back(measured_arcsec / prediction.separation_arcsec);
        seen.push_back(prediction);
        starts.push_back(measured.exposures[i].intervals.front().start_ns);
    }
    if (series.t.empty())
        fail(Status::range, "{measured}: the observer is not known for the time of any sample");
    check_unit(std::move(ratios));
    series.position_angle_deg = std::move(angles);
    set_stars(predictor.system(), starts, series);
    std::string warning;
    const size_t offsets = series.instruments.empty() ? 0 : series.instruments.size() - 1;
    if (with_functions && series.functions() == offsets)
        warning = add_functions(seen, predictor, scale_sigma, series);
    return {std::move(series), std::move(warning)};
}

std::vector<sky::Measurement> measurements_of(const Series &measured) {
    check_measured(measured);
    if (measured.sigma.empty())
        fail(Status::argument, "{measured}: has no sigma: must have the standard deviation of each separation");
    std::vector<sky::Measurement> measurements;
    measurements.reserve(measured.count());
    for (size_t i = 0; i < measured.count(); i++)
        measurements.push_back(
            {measured.exposures[i], measured.y[i] * measured.unit, measured.sigma[i] * measured.unit});
    return measurements;
}

std::vector<sky::Measurement> covered(const sky::Predictor &predictor, std::vector<sky::Measurement> measurements) {
    size_t place = 0;
    const auto is_missing = [&](const sky::Measurement &measurement) {
        try {
            place++;
            const sky::ExposureMean mean = mean_over(predictor, measurement.exposure);
            if (mean.outcome == sky::ExposureMean::Outcome::unknown)
                fail(Status::argument, "{intervals}: %s", mean.why.c_str());
            return mean.outcome == sky::ExposureMean::Outcome::no_state;
        } catch (const Error &error) {
            fail_within(error, error.status(), "measurement %zu: %s", place - 1, error.what());
        }
    };
    measurements.erase(std::remove_if(measurements.begin(), measurements.end(), is_missing), measurements.end());
    if (measurements.empty())
        fail(Status::range, "{measured}: the observer is not known for the time of any sample");
    return measurements;
}

} // namespace toliman::measure
