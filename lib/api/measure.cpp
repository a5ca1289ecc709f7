// include/toliman/measure.h
#include <toliman/measure.h>

#include "api/common.hpp"

#include <filesystem>
#include <system_error>

#include "api/measure_handle.hpp"
#include "api/series_options.hpp"
#include "api/sky_measurements.hpp"
#include "api/times.hpp"
#include "backend/file.hpp"
#include "base/progress.hpp"
#include "base/words.hpp"
#include "measure/columns.hpp"
#include "measure/text.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

constexpr size_t kLargestFile = size_t{1} << 36;

// Replaces values by those of the caller, if there are any.
void replace(const double *given, size_t n, std::vector<double> &values) {
    if (given != nullptr)
        values.assign(given, given + n);
}

void set_exposures(const toliman_measure_data &data, measure::Series &series) {
    if (data.intervals == nullptr)
        return;
    series.exposures = exposures_of(data.intervals, data.interval_counts, data.n);
    for (size_t i = 0; i < data.n; i++)
        if (series.exposures[i].intervals.empty())
            fail(Status::argument, "{data->interval_counts[%zu]} = 0: must be at least 1", i);
    check_exposures(series.exposures);
    if (series.t.empty())
        series.set_times_of_exposures();
}

// A series whose members those of the caller replace.
measure::Series start_of(toliman_measure_data &data) {
    if (data.original != nullptr) {
        const Use original(data.original, "data->original");
        data.n = data.n == 0 ? original->series.count() : data.n;
        check_count("data->n", data.n, original->series.count(), "the number of samples of the original");
        return original->series;
    }
    if (data.t == nullptr && data.intervals == nullptr)
        required_array(data.t, data.n, sizeof(double), "data->t");
    required_array(data.y, data.n, sizeof(double), "data->y");
    return {};
}

measure::Series series_of(toliman_measure_data data) {
    measure::Series series = start_of(data);
    series.kind = kMeasureKinds.to_enum_or(data.kind, series.kind, "data->kind");
    if (data.t != nullptr) {
        series.set_plain_times({data.t, data.t + data.n});
        series.exposures.clear(); // an original's, of other times
    }
    replace(data.y, data.n, series.y);
    replace(data.sigma, data.n, series.sigma);
    replace(data.position_angle_deg, data.n, series.position_angle_deg);
    series.unit = measure::known_unit(data.unit != 0 ? data.unit : series.unit, series.kind);
    if (!(data.time_unit_days >= 0 && data.time_unit_days <= 1e12))
        fail(Status::argument, "{data->time_unit_days} = %g: must be in (0, 1e12], or 0 for 1", data.time_unit_days);
    if (data.time_unit_days != 0)
        series.time_unit_days = data.time_unit_days;
    if (!(data.frame_chi_square >= 0 && data.frame_chi_square <= 1e100))
        fail(Status::argument, "{data->frame_chi_square} = %g: must be in (0, 1e100], or 0", data.frame_chi_square);
    if (data.frame_chi_square != 0)
        series.frame_chi_square = data.frame_chi_square;
    if (data.name != nullptr)
        series.name = data.name;
    if (series.kind == measure::Kind::velocity && data.position_angle_deg != nullptr)
        fail(Status::argument, "{data->position_angle_deg}: must be NULL for velocities");
    set_exposures(data, series);
    check(series);
    return series;
}

measure::Series series_of(std::string_view bytes, const char *name, const toliman_measure_options &options) {
    toliman_series_options lines = {};
    lines.struct_size = sizeof lines;
    TOLIMAN_COPY(lines, options, flags, time_format, time_scale, columns, instrument, leap_seconds, leap_second_count);
    lines.name = name;
    const ingest::SeriesOptions how = series_options(accept(&lines, "options"));
    measure::Text text = measure::read_text(bytes, how);
    std::optional<measure::Kind> kind;
    if (options.kind != 0)
        kind = kMeasureKinds.to_enum(options.kind);
    measure::set_unit(kind, options.unit, text);
    for (const std::string &warning : text.warnings)
        Log{options.log, options.log_data}.warn("%s", warning.c_str());
    text.series.set_exposures(options.exposure_s);
    if (options.functions != nullptr) {
        const std::vector<uint8_t> table = file::read(options.functions, kLargestFile);
        measure::add_columns({reinterpret_cast<const char *>(table.data()), table.size()}, options.functions, how,
                             text.series);
    }
    check(text.series);
    return text.series;
}

bool is_folder(const char *path) {
    std::error_code unknown;
    return std::filesystem::is_directory(path, unknown);
}

bool has_length(const sky::Exposure &exposure) noexcept {
    return exposure.intervals.front().start_ns != exposure.intervals.back().end_ns;
}

double precision_of(double sigma) {
    if (!(sigma == 0 || (sigma >= 1e-98 && sigma <= 1e98)))
        fail(Status::argument, "{sigma} = %g: must be in [1e-98, 1e98], or 0 for no prior", sigma);
    return sigma == 0 ? 0 : 1 / (sigma * sigma);
}

} // namespace

extern "C" {

toliman_status toliman_measure_create(const toliman_measure_data *data, toliman_measure **out) noexcept {
    return guard([&] {
        toliman_measure *&made = required(out, "out");
        made = new toliman_measure{{}, series_of(copied(&required(data, "data"), "data"))};
    });
}

toliman_status toliman_measure_load(const void *bytes, size_t size, const char *name,
                                    const toliman_measure_options *options, toliman_measure **out) noexcept {
    return guard([&] {
        toliman_measure *&made = required(out, "out");
        required_array(bytes, size, 1, "bytes");
        made = new toliman_measure{
            {}, series_of({static_cast<const char *>(bytes), size}, name, accept(options, "options"))};
    });
}

toliman_status toliman_measure_load_file(const char *path, const toliman_measure_options *options,
                                         toliman_measure **out) noexcept {
    return guard([&] {
        required(path, "path");
        toliman_measure *&made = required(out, "out");
        const auto known = accept(options, "options");
        if (is_folder(path)) {
            made = new toliman_measure{{}, series_of_folder(path, known)};
            return;
        }
        const std::vector<uint8_t> bytes = file::read(path, kLargestFile);
        made = new toliman_measure{
            {}, series_of({reinterpret_cast<const char *>(bytes.data()), bytes.size()}, path, known)};
    });
}

void toliman_measure_destroy(toliman_measure *measure) noexcept {
    destroy(measure);
}

toliman_status toliman_measure_set_trend(toliman_measure *measure, int32_t order, double start, double end) noexcept {
    return call(measure, "measure", [&](auto &self) {
        measure::Series &series = self.series;
        if (order < 0 || order > measure::kMostTrend)
            fail(Status::argument, "{order} = %d: must be in [0, %d]", order, measure::kMostTrend);
        if (static_cast<size_t>(order) + series.columns.size() > measure::kMostFunctions)
            fail(Status::argument, "{order} = %d: with %zu columns, must be at most %zu together", order,
                 series.columns.size(), measure::kMostFunctions);
        if (!(std::fabs(start) <= 1e100) || !(std::fabs(end) <= 1e100))
            fail(Status::argument, "{start} = %g, end = %g: must be finite and at most 1e100", start, end);
        series.set_trend(order, start, end);
    });
}

toliman_status toliman_measure_add_column(toliman_measure *measure, const char *name, const double *values, size_t n,
                                          double sigma) noexcept {
    return call(measure, "measure", [&](auto &self) {
        measure::Series &series = self.series;
        required(name, "name");
        const double precision = precision_of(sigma);
        required_array(values, n, sizeof *values, "values");
        check_count("n", n, series.count(), "the number of samples");
        series.add_column(name, {values, values + n}, precision);
    });
}

toliman_status toliman_measure_set_instruments(toliman_measure *measure, const char *names, const int64_t *instrument,
                                               size_t n) noexcept {
    return call(measure, "measure", [&](auto &self) {
        std::vector<std::string> list = words_of(&required(names, "names"));
        std::vector<int32_t> of_samples;
        if (!list.empty())
            required_array(instrument, n, sizeof *instrument, "instrument");
        for (size_t i = 0; i < n && !list.empty(); i++)
            of_samples.push_back(static_cast<int32_t>(std::clamp<int64_t>(instrument[i], -1, INT32_MAX)));
        measure::Series changed = self.series;
        changed.set_instruments(std::move(list), std::move(of_samples));
        check(changed);
        self.series = std::move(changed);
    });
}

toliman_status toliman_measure_set_prior(toliman_measure *measure, int64_t function, double sigma) noexcept {
    return call(measure, "measure", [&](auto &self) {
        const size_t known = required_index(function, self.series.functions(), "function");
        self.series.precision(known) = precision_of(sigma);
    });
}

toliman_status toliman_measure_get_info(const toliman_measure *measure, toliman_measure_info *out) noexcept {
    return query(measure, "measure", out, [&](auto &self, auto &info) {
        const measure::Series &series = self.series;
        info.kind = kMeasureKinds.to_constant(series.kind);
        info.n = static_cast<int64_t>(series.count());
        info.left_out = static_cast<int64_t>(series.left_out);
        info.functions = static_cast<int64_t>(series.functions());
        info.trend = series.trend.order;
        info.columns = static_cast<int32_t>(series.columns.size());
        if (series.dates) {
            info.time_format = kFormats.to_constant(series.dates->format);
            info.time_scale = kScales.to_constant(series.dates->scale);
        }
        info.is_weighted = series.sigma.empty() ? 0 : 1;
        info.has_exposures = std::any_of(series.exposures.begin(), series.exposures.end(), has_length) ? 1 : 0;
        info.instruments = static_cast<int64_t>(series.instruments.size());
        info.instrument_names = series.instrument_names.c_str();
        info.trend_start = series.trend.start;
        info.trend_end = series.trend.end;
        info.unit = series.unit;
        put_text(series.unit_name, info.unit_name);
        TOLIMAN_COPY(info, series, time_unit_days, frame_chi_square, parallax_arcsec);
        info.is_refitted = series.is_refitted;
        info.name = series.name.c_str();
        std::copy(std::begin(series.star_mass), std::end(series.star_mass), info.star_mass);
    });
}

toliman_status toliman_measure_get_function(const toliman_measure *measure, int64_t index,
                                            toliman_measure_function *out) noexcept {
    return query(measure, "measure", out, [&](auto &self, auto &found) {
        const measure::Series &series = self.series;
        const size_t f = required_index(index, series.functions(), "index");
        const auto order = static_cast<size_t>(series.trend.order);
        found.sigma = series.precision(f) > 0 ? 1 / std::sqrt(series.precision(f)) : 0;
        found.unit = f < order ? 1 : series.columns[f - order].unit;
        found.bound = f < order ? 1 : series.columns[f - order].bound;
        put_text(series.function_name(f), found.name);
    });
}

toliman_status toliman_measure_get_values(const toliman_measure *measure, const char *name, double *values,
                                          size_t n) noexcept {
    return call(measure, "measure", [&](auto &self) {
        required(name, "name");
        required_array(values, n, sizeof *values, "values");
        check_count("n", n, self.series.count(), "the number of samples");
        const std::vector<double> found = self.series.values(name);
        std::copy(found.begin(), found.end(), values);
    });
}

toliman_status toliman_measure_get_times(const toliman_measure *measure, int64_t *tai_ns, size_t n) noexcept {
    return call(measure, "measure", [&](auto &self) {
        required_array(tai_ns, n, sizeof *tai_ns, "tai_ns");
        check_count("n", n, self.series.count(), "the number of samples");
        const std::vector<int64_t> times = measure::tai_of(self.series);
        std::copy(times.begin(), times.end(), tai_ns);
    });
}

} // extern "C"
