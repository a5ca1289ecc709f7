#include "downlink/planet_state.hpp"

#include <algorithm>

#include <toliman/toliman.hpp>

#include "downlink/state_folder.hpp"
#include "downlink/tracked_series.hpp"

namespace cli {

namespace {

constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;
constexpr size_t kAtOnce = 4096; // records

// Position angles on the orbit. They do not depend on the observer: the light time within the orbit of the Earth
// changes them by 1e-4 deg.
std::vector<double> position_angles(const std::string &system, const Series &series) {
    const auto sky = toliman::make<toliman::sky_predictor>(toliman_sky_create, system.c_str(), nullptr);
    const std::vector<int64_t> times = tai_of(series);
    std::vector<toliman_sky_prediction> seen(times.size(), toliman::sized<toliman_sky_prediction>());
    toliman::check(toliman_sky_predict(sky.get(), times.data(), times.size(), seen.data()));
    std::vector<double> angles;
    angles.reserve(seen.size());
    for (const toliman_sky_prediction &prediction : seen)
        angles.push_back(prediction.geometric_angle_deg);
    return angles;
}

// Median chi-square of the accepted frames; 0 if the ledger does not have it.
double median_chi_square(const toliman::tracker &tracker) {
    std::vector<double> found;
    std::vector<toliman_track_record> records(kAtOnce);
    std::vector<double> values(kAtOnce);
    records[0].struct_size = sizeof records[0];
    size_t count = kAtOnce;
    for (int64_t first = 0; count == kAtOnce; first += static_cast<int64_t>(kAtOnce)) {
        toliman::check(toliman_track_get_records(tracker.get(), first, kAtOnce, records.data(), &count));
        const toliman_status status =
            toliman_track_get_column(tracker.get(), "chi_square", first, count, values.data(), &count);
        if (status == TOLIMAN_E_NOT_FOUND)
            return 0;
        toliman::check(status);
        for (size_t i = 0; i < count; i++)
            if (records[i].verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED && values[i] > 0)
                found.push_back(values[i]);
    }
    if (found.empty())
        return 0;
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end());
    return *middle;
}

} // namespace

StateSeries dated_series(const std::string &folder, Progress &progress) {
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    const toliman_track_options how = settings_of(tracker);
    const toliman_track_info info = info_of(tracker);
    StateSeries state = {tracked_series(tracker), info.plate_scale_arcsec, info.system != nullptr ? info.system : ""};
    Series &series = state.series;
    if (series.t.empty())
        malformed(folder, "has no accepted frame: see `toliman status`");
    const double zero = kMjdOf1970 + static_cast<double>(how.time_offset_ns) / kNsPerDay;
    const auto date = [&](double t) { return zero + t * (static_cast<double>(how.unit_ns) / kNsPerDay); };
    for (double &t : series.t)
        t = date(t);
    series.nuisance.trend.start = date(series.nuisance.trend.start);
    series.nuisance.trend.end = date(series.nuisance.trend.end);
    series.name = folder;
    series.time_scale = "TAI";
    series.frame_chi_square = median_chi_square(tracker);
    if (!state.system.empty())
        series.position_angle_deg = position_angles(state.system, series);
    return state;
}

} // namespace cli
