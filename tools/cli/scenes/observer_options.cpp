#include "scenes/observer_options.hpp"

#include <filesystem>

#include "options/command.hpp"
#include "scenes/dates.hpp"
#include "scenes/leap_seconds.hpp"
#include "scenes/scene.hpp"
#include "scenes/sky_times.hpp"

namespace cli {

namespace {

double per_minute(const toliman_sky_info &info) {
    return static_cast<double>(info.states) / (static_cast<double>(info.last_ns - info.first_ns) / 60e9);
}

} // namespace

double plate_scale_of(const std::optional<double> &given, double otherwise) {
    const double scale = given.value_or(otherwise);
    if (!(scale > 0 && std::isfinite(scale)))
        throw Failure(kExitUsage, formatted("--plate-scale %g: must be above 0 arcsec per px and finite", scale));
    return scale;
}

void ObserverOptions::add_to(CLI::App &command, Times times) {
    CLI::Option *const observer = add_option(&command, "--observer", file_, "FILE");
    CLI::Option *const altitude = add_option(&command, "--altitude", altitude_, "KM");
    altitude->excludes(observer);
    add_option(&command, "--node", node_, "HOURS")->needs(altitude);
    if (times == Times::own)
        add_option(&command, "--leap-seconds", leap_seconds_, "FILE");
}

void ObserverOptions::add_file_to(CLI::App &command) {
    add_option(&command, "--observer", file_, "FILE");
    add_option(&command, "--leap-seconds", leap_seconds_, "FILE");
}

void ObserverOptions::use_scene(const SceneDefaults &scene, Notes &notes) {
    if (!scene.has_observer)
        return;
    ObserverOptions of_scene;
    if (!scene.observer_file.empty())
        of_scene.file_ = scene.observer_file;
    of_scene.altitude_ = scene.altitude_km;
    of_scene.node_ = scene.node_hours;
    std::error_code none;
    const bool is_same = file_ && of_scene.file_ ? std::filesystem::equivalent(*file_, *of_scene.file_, none)
                                                 : text() == of_scene.text();
    if (given() && !is_same)
        notes.push_back("observer: " + text() + " instead of binary.observer of " + scene.path + ", " +
                        of_scene.text());
    if (given())
        return;
    file_ = of_scene.file_;
    altitude_ = of_scene.altitude_;
    node_ = of_scene.node_;
}

void ObserverOptions::check() const {
    if (altitude_ && !(*altitude_ >= 200 && *altitude_ <= 2000))
        throw Failure(kExitUsage, formatted("--altitude %g: must be in [200, 2000] km", *altitude_));
    if (node_ && !(*node_ >= 0 && *node_ <= 24))
        throw Failure(kExitUsage, formatted("--node %g: must be in [0, 24] h", *node_));
}

double ObserverOptions::node_hours() const {
    return node_.value_or(18);
}

toliman::sky_predictor ObserverOptions::predictor(const std::string &system, uint32_t without,
                                                  Progress &progress) const {
    check();
    const LeapSeconds table(leap_seconds_);
    auto how = with_warnings<toliman_sky_options>(progress);
    if (file_)
        how.observer = file_->c_str();
    how.altitude_km = altitude_.value_or(0);
    if (altitude_)
        how.node_hours = node_hours() == 0 ? 24 : node_hours(); // 0 in the struct is its default
    how.without = without;
    how.leap_seconds = table.rows.data();
    how.leap_second_count = table.rows.size();
    return toliman::make<toliman::sky_predictor>(toliman_sky_create, system.c_str(), &how);
}

std::string ObserverOptions::coverage(const toliman_sky *sky) const {
    if (!file_)
        return text() + ", is known at all times";
    const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky);
    return *file_ + " has states from " + date_text(info.first_ns) + " to " + date_text(info.last_ns) + " TAI";
}

std::string ObserverOptions::orbit(const toliman_sky *sky) const {
    if (!file_)
        return "";
    const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky);
    const auto day = [](int64_t ns) { return date_text(ns).substr(0, std::strlen("2029-01-01")); };
    return *file_ +
           formatted(": altitude %.0f to %.0f km, inclination %.1f deg, ascending node at %.1f h local time, ",
                     info.altitude_km[0], info.altitude_km[1], info.inclination_deg, info.node_hours) +
           day(info.first_ns) + " to " + day(info.last_ns) + formatted(", %.2g states per minute", per_minute(info));
}

void ObserverOptions::set_orbit(Json &json, const toliman_sky *sky) const {
    std::optional<Json> orbit;
    if (file_) {
        const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky);
        orbit = Json("altitude_min_km", info.altitude_km[0], "altitude_max_km", info.altitude_km[1], "inclination_deg",
                     info.inclination_deg, "node_deg", info.node_deg, "node_hours", info.node_hours, "period_minutes",
                     info.orbit_minutes, "first_tai", date_text(info.first_ns), "last_tai", date_text(info.last_ns),
                     "segments", info.segments, "states", info.states);
    }
    json.set("observer_orbit", orbit);
}

std::string ObserverOptions::options() const {
    return (file_ ? " --observer " + *file_ : "") + (altitude_ ? formatted(" --altitude %.17g", *altitude_) : "") +
           (node_ ? formatted(" --node %.17g", *node_) : "");
}

std::string ObserverOptions::name() const {
    return toliman_constant_name(altitude_ ? TOLIMAN_SKY_OBSERVER_CIRCULAR
                                 : file_   ? TOLIMAN_SKY_OBSERVER_FILE
                                           : TOLIMAN_SKY_OBSERVER_EARTH);
}

std::string ObserverOptions::text() const {
    if (altitude_)
        return name() + formatted(", altitude %g km, node at %g h", *altitude_, node_hours());
    return file_ ? *file_ : "centre of the " + name();
}

void ObserverOptions::set(Json &json) const {
    json.set("observer", name(), "observer_file", file_, "altitude_km", altitude_, "node_hours",
             if_known(altitude_.has_value(), node_hours()));
}

} // namespace cli
