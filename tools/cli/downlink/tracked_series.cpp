#include "downlink/tracked_series.hpp"

#include <algorithm>
#include <string>

#include "downlink/state_folder.hpp"

namespace cli {

namespace {

constexpr size_t kAtOnce = 4096; // records

std::vector<int32_t> elements_of(const toliman_track_info &info) {
    std::vector<int32_t> elements;
    for (int32_t i = 0; i < static_cast<int32_t>(TOLIMAN_SKY_ELEMENTS); i++)
        if ((info.elements >> i & 1) != 0)
            elements.push_back(i);
    return elements;
}

// The derivatives by an element, of the records from `first` on.
std::vector<double> derivatives(const toliman::tracker &tracker, int32_t element, int64_t first, size_t count) {
    std::vector<double> values(count);
    const std::string name = std::string("d_") + toliman_sky_element_name(element);
    toliman::check(toliman_track_get_column(tracker.get(), name.c_str(), first, count, values.data(), &count));
    return values;
}

Nuisance functions_of(const toliman::tracker &tracker, const toliman_track_options &how) {
    const toliman_period *period = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &period));
    const auto info = info_from<toliman_period_info>(toliman_period_get_info, period);
    Nuisance nuisance;
    nuisance.trend = {std::max(0, how.trend), how.trend_start, how.trend_end};
    nuisance.columns = element_columns(tracker);
    for (size_t c = 0; c < nuisance.columns.size(); c++)
        nuisance.columns[c].bound = info.column_bound[c];
    nuisance.precision.assign(info.prior_precision + 1, info.prior_precision + 1 + nuisance.count());
    return nuisance;
}

} // namespace

double time_of(const toliman_track_record &line, const toliman_track_options &how) {
    const long double elapsed = static_cast<long double>(line.tai_ns) - static_cast<long double>(how.time_offset_ns);
    return static_cast<double>(elapsed / static_cast<long double>(how.unit_ns));
}

std::vector<NuisanceColumn> element_columns(const toliman::tracker &tracker) {
    const toliman_track_info info = info_of(tracker);
    std::vector<NuisanceColumn> columns;
    for (const int32_t element : elements_of(info))
        columns.push_back({toliman_sky_element_name(element), {}, 0, info.plate_scale_arcsec});
    return columns;
}

Series tracked_series(const toliman::tracker &tracker) {
    const toliman_track_options how = settings_of(tracker);
    const std::vector<int32_t> elements = elements_of(info_of(tracker));
    Series series;
    series.name = how.folder != nullptr ? how.folder : "";
    series.nuisance = functions_of(tracker, how);
    std::vector<toliman_track_record> lines(kAtOnce);
    lines[0].struct_size = sizeof lines[0];
    size_t count = kAtOnce;
    for (int64_t first = 0; count == kAtOnce; first += static_cast<int64_t>(kAtOnce)) {
        toliman::check(toliman_track_get_records(tracker.get(), first, kAtOnce, lines.data(), &count));
        std::vector<std::vector<double>> columns;
        for (const int32_t element : elements)
            columns.push_back(derivatives(tracker, element, first, count));
        for (size_t i = 0; i < count; i++) {
            if (lines[i].verdict != TOLIMAN_TRACK_VERDICT_ACCEPTED)
                continue;
            series.t.push_back(time_of(lines[i], how));
            series.y.push_back(lines[i].value);
            series.sigma.push_back(lines[i].sigma);
            for (size_t c = 0; c < columns.size(); c++)
                series.nuisance.columns[c].values.push_back(columns[c][i]);
        }
    }
    return series;
}

} // namespace cli
