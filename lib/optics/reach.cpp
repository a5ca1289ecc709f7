#include "optics/reach.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::optics {

namespace {

constexpr double kFarSigmas = 4;    // of a disturbance
constexpr size_t kOrbitSteps = 256; // over the cadence

// Times from 0 through all frames, or of one turn if that is shorter, in steps that are short against the orbit; none
// where the stars stand still.
std::vector<double> orbit_days(const Scene &scene) {
    std::vector<double> days;
    if (!scene.binary.moving)
        return days;
    const std::vector<double> &times = scene.cadence.times_days;
    double first = 0, last = longest_days(scene.cadence);
    if (!times.empty()) {
        first = std::min(0.0, *std::min_element(times.begin(), times.end()));
        last = std::max(0.0, *std::max_element(times.begin(), times.end()));
    }
    const double turn = scene.binary.orbit->period_years * kDaysPerYear;
    const double step = std::min(last - first, turn) / kOrbitSteps;
    for (size_t i = 0; i <= kOrbitSteps; i++)
        days.push_back(first + static_cast<double>(i) * step);
    return days;
}

} // namespace

double farthest_of(const Signal &signal) noexcept {
    return signal.amplitude_px * (1 + signal.eccentricity);
}

double reach_of(const Disturbance &disturbance, const Cadence &cadence) noexcept {
    return kFarSigmas * disturbance.rms + std::fabs(disturbance.drift_per_day) * longest_days(cadence);
}

double span_days(const Cadence &cadence) noexcept {
    if (cadence.times_days.empty())
        return longest_days(cadence);
    const auto [first, last] = std::minmax_element(cadence.times_days.begin(), cadence.times_days.end());
    return *last - *first;
}

double orbit_px_a_day(const Scene &scene, const Light &light) {
    const std::vector<double> days = orbit_days(scene);
    double fastest = 0;
    for (size_t i = 1; i < days.size() && days[i] > days[i - 1]; i++) {
        const Offsets a = offsets_at(scene, light, days[i - 1]), b = offsets_at(scene, light, days[i]);
        for (size_t star = 0; star < 2; star++) {
            const double way = std::hypot(b[star][0] - a[star][0], b[star][1] - a[star][1]);
            fastest = std::max(fastest, way / (days[i] - days[i - 1]));
        }
    }
    return fastest;
}

Light farthest_on_orbit(const Scene &scene, const Light &light) {
    Light farthest = light;
    for (const double days : orbit_days(scene)) {
        const Offsets there = offsets_at(scene, light, days);
        for (size_t star = 0; star < 2; star++)
            for (size_t axis = 0; axis < 2; axis++)
                if (std::fabs(there[star][axis]) > std::fabs(farthest.offset_px[star][axis]))
                    farthest.offset_px[star][axis] = there[star][axis];
    }
    return farthest;
}

double wandering_px(const Scene &scene, const Light &light) noexcept {
    double farthest = 0;
    for (size_t star = 0; star < scene.stars.size(); star++)
        farthest = std::max(farthest, std::hypot(light.offset_px[star][0], light.offset_px[star][1]));
    return std::sqrt(2) * reach_of(scene.systematics.pointing_px, scene.cadence) +
           farthest * reach_of(scene.systematics.roll_rad, scene.cadence);
}

Light farthest_out(const Scene &scene, const Light &on_orbit) {
    Light farthest = on_orbit;
    const double moved = wandering_px(scene, on_orbit) + farthest_of(scene.signal);
    for (auto &offset : farthest.offset_px)
        for (double &place : offset)
            place += std::copysign(moved, place);
    return farthest;
}

} // namespace toliman::optics
