#include "downlink/tracked_series.hpp"

#include <algorithm>
#include <string>

#include "downlink/state_folder.hpp"
#include "series/measure.hpp"

namespace cli {

double time_of(int64_t tai_ns, const toliman_track_options &how) {
    const long double elapsed = static_cast<long double>(tai_ns) - static_cast<long double>(how.grid.time_offset_ns);
    return static_cast<double>(elapsed / static_cast<long double>(how.grid.unit_ns));
}

std::vector<NuisanceColumn> element_columns(const toliman::tracker &tracker) {
    const toliman_track_info info = info_of(tracker);
    std::vector<NuisanceColumn> columns;
    for (int32_t i = 0; i < static_cast<int32_t>(TOLIMAN_SKY_ELEMENTS); i++)
        if ((info.elements >> i & 1) != 0)
            columns.push_back({toliman_constant_name(TOLIMAN_SKY_ELEMENT_PERIOD + i), {}, 0, info.plate_scale_arcsec});
    return columns;
}

Series tracked_series(const toliman::tracker &tracker) {
    const toliman_track_options how = settings_of(tracker);
    const std::string name = how.folder != nullptr ? how.folder : "";
    Series series;
    series.name = name;
    if (info_of(tracker).accepted == 0)
        return series;
    const toliman::measurements measure = accepted_frames(tracker, name);
    series = series_of(measure.get(), name);
    std::vector<int64_t> times(series.t.size());
    toliman::check(toliman_measure_get_times(measure.get(), times.data(), times.size()));
    std::transform(times.begin(), times.end(), series.t.begin(), [&](int64_t tai_ns) { return time_of(tai_ns, how); });
    series.nuisance.trend = {std::max(0, how.grid.trend), how.grid.trend_start, how.grid.trend_end};
    series.time_scale.clear();
    series.time_format = 0;
    return series;
}

} // namespace cli
