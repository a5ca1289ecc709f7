#include "downlink/planet_state.hpp"

#include <toliman/toliman.hpp>

#include "downlink/state_folder.hpp"
#include "downlink/tracked_series.hpp"

namespace cli {

namespace {

constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;

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

} // namespace

StateSeries dated_series(const std::string &folder, Progress &progress) {
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    const toliman_track_options how = settings_of(tracker);
    const toliman_track_info info = info_of(tracker);
    StateSeries state = {tracked_series(tracker), info.plate_scale_arcsec, info.system != nullptr ? info.system : ""};
    Series &series = state.series;
    if (series.t.empty())
        malformed(folder, "has no accepted frame");
    const double zero = kMjdOf1970 + static_cast<double>(how.time_offset_ns) / kNsPerDay;
    const auto date = [&](double t) { return zero + t * (static_cast<double>(how.unit_ns) / kNsPerDay); };
    for (double &t : series.t)
        t = date(t);
    series.nuisance.trend.start = date(series.nuisance.trend.start);
    series.nuisance.trend.end = date(series.nuisance.trend.end);
    series.name = folder;
    series.time_scale = "TAI";
    if (!state.system.empty())
        series.position_angle_deg = position_angles(state.system, series);
    return state;
}

} // namespace cli
