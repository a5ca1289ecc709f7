#include "series/measure.hpp"

#include <algorithm>
#include <cmath>

#include "common/library.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

const double *data_or_null(const std::vector<double> &values) {
    return values.empty() ? nullptr : values.data();
}

// Whether a column is the offset of an instrument, which comes with the instruments.
bool is_offset(const std::string &name, const Series &series) {
    return std::any_of(series.instruments.begin(), series.instruments.end(),
                       [&](const std::string &instrument) { return name == "offset " + instrument; });
}

// The names of a list with commas.
std::vector<std::string> names_in(const std::string &list) {
    std::vector<std::string> names(1);
    for (const char letter : list)
        if (letter == ',')
            names.emplace_back();
        else
            names.back() += letter;
    return names;
}

void add_functions(const Series &series, toliman_measure *measure) {
    if (!series.instruments.empty())
        toliman::check(toliman_measure_set_instruments(measure, (joined(series.instruments, ",") + ",").c_str(),
                                                       series.instrument.data(), series.instrument.size()));
    const Nuisance &nuisance = series.nuisance;
    const Trend &trend = nuisance.trend;
    toliman::check(toliman_measure_set_trend(measure, trend.order, trend.start, trend.end));
    for (const NuisanceColumn &column : nuisance.columns)
        if (!is_offset(column.name, series))
            toliman::check(toliman_measure_add_column(measure, column.name.c_str(), column.values.data(),
                                                      column.values.size(), 0));
    for (size_t f = 0; f < nuisance.precision.size(); f++)
        if (nuisance.precision[f] > 0)
            toliman::check(
                toliman_measure_set_prior(measure, static_cast<int64_t>(f), 1 / std::sqrt(nuisance.precision[f])));
}

} // namespace

toliman::measurements measure_of(const Series &series, int32_t kind, double unit,
                                 const std::vector<int64_t> &intervals) {
    auto data = toliman::sized<toliman_measure_data>();
    data.kind = kind;
    data.n = series.t.size();
    data.t = series.t.data();
    data.y = series.y.data();
    data.sigma = data_or_null(series.sigma);
    data.intervals = intervals.empty() ? nullptr : intervals.data();
    data.position_angle_deg = data_or_null(series.position_angle_deg);
    data.unit = unit;
    data.time_unit_days = series.time_unit_days;
    data.frame_chi_square = series.frame_chi_square;
    auto measure = toliman::make<toliman::measurements>(toliman_measure_create, &data);
    add_functions(series, measure.get());
    return measure;
}

std::vector<std::vector<double>> functions_of(const Series &series) {
    const toliman::measurements measure = measure_of(series, 0, 0);
    std::vector<std::vector<double>> values;
    for (int64_t f = 0; f < info_of(measure.get()).functions; f++) {
        auto function = toliman::sized<toliman_measure_function>();
        toliman::check(toliman_measure_get_function(measure.get(), f, &function));
        values.push_back(values_of(measure.get(), function.name));
    }
    return values;
}

Series series_of(const toliman_measure *measure, const std::string &name) {
    const toliman_measure_info info = info_of(measure);
    Series series;
    series.name = name;
    series.t = values_of(measure, "t");
    series.y = values_of(measure, "y");
    series.sigma = values_of(measure, "sigma");
    series.position_angle_deg = values_of(measure, "position_angle_deg");
    series.time_scale = name_of_scale(info.time_scale);
    series.time_format = info.time_format;
    series.frame_chi_square = info.frame_chi_square;
    series.unit_name = info.unit_name;
    series.time_unit_days = info.time_unit_days;
    if (info.instruments > 0) {
        series.instruments = names_in(info.instrument_names);
        for (const double which : values_of(measure, "instrument"))
            series.instrument.push_back(std::llround(which));
    }
    Nuisance &nuisance = series.nuisance;
    nuisance.trend = {info.trend, info.trend_start, info.trend_end};
    bool has_priors = false;
    for (int64_t f = 0; f < info.functions; f++) {
        auto function = toliman::sized<toliman_measure_function>();
        toliman::check(toliman_measure_get_function(measure, f, &function));
        nuisance.precision.push_back(function.sigma > 0 ? 1 / (function.sigma * function.sigma) : 0);
        has_priors = has_priors || function.sigma > 0;
        if (f >= info.trend)
            nuisance.columns.push_back(
                {function.name, values_of(measure, function.name), function.bound, function.unit});
    }
    if (!has_priors)
        nuisance.precision.clear();
    return series;
}

} // namespace cli
