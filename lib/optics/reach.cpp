// Method: the signal moves its star by at most a (1 + e), a systematic by 4 sigma plus its largest drift, and the
// orbit by its largest offset in 256 steps over the cadence or over one orbital period. The plan predicts errors at
// these values. 4 sigma are exceeded by 6e-5 of the normal variates.
#include "optics/reach.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::optics {

namespace {

constexpr double kSigmas = 4;       // of a disturbance
constexpr size_t kOrbitSteps = 256; // over the cadence

// kOrbitSteps equal steps over time 0 and all frames, or over one orbital period if that is shorter; empty if the stars
// do not follow the orbit.
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
    const double period = scene.binary.orbit->period_years * sky::kDaysPerYear;
    const double step = std::min(last - first, period) / kOrbitSteps;
    for (size_t i = 0; i <= kOrbitSteps; i++)
        days.push_back(first + static_cast<double>(i) * step);
    return days;
}

} // namespace

double max_signal_px(const Signal &signal) noexcept {
    return signal.amplitude_px * (1 + signal.eccentricity);
}

double four_sigma_of(const Disturbance &disturbance, const Cadence &cadence) noexcept {
    return kSigmas * disturbance.rms + std::fabs(disturbance.drift_per_day) * longest_days(cadence);
}

double orbit_px_per_day(const Scene &scene, const Light &light) {
    const std::vector<double> days = orbit_days(scene);
    double fastest = 0;
    for (size_t i = 1; i < days.size() && days[i] > days[i - 1]; i++) {
        const Offsets a = orbit_offsets_at(scene, light, days[i - 1]), b = orbit_offsets_at(scene, light, days[i]);
        for (size_t star = 0; star < 2; star++) {
            const double distance = std::hypot(b[star][0] - a[star][0], b[star][1] - a[star][1]);
            fastest = std::max(fastest, distance / (days[i] - days[i - 1]));
        }
    }
    return fastest;
}

Light farthest_on_orbit(const Scene &scene, const Light &light) {
    Light farthest = light;
    for (const double days : orbit_days(scene)) {
        const Offsets offsets = orbit_offsets_at(scene, light, days);
        for (size_t star = 0; star < 2; star++)
            for (size_t axis = 0; axis < 2; axis++)
                if (std::fabs(offsets[star][axis]) > std::fabs(farthest.offset_px[star][axis]))
                    farthest.offset_px[star][axis] = offsets[star][axis];
    }
    return farthest;
}

double systematic_shift_px(const Scene &scene, const Light &light) noexcept {
    double farthest = 0;
    for (size_t star = 0; star < scene.stars.size(); star++)
        farthest = std::max(farthest, std::hypot(light.offset_px[star][0], light.offset_px[star][1]));
    return std::sqrt(2) * four_sigma_of(scene.systematics.pointing_px, scene.cadence) +
           farthest * four_sigma_of(scene.systematics.roll_rad, scene.cadence);
}

Light farthest_with_shifts(const Scene &scene, const Light &on_orbit) {
    Light farthest = on_orbit;
    const double shift = systematic_shift_px(scene, on_orbit) + max_signal_px(scene.signal);
    for (auto &offset : farthest.offset_px)
        for (double &position : offset)
            position += std::copysign(shift, position);
    return farthest;
}

} // namespace toliman::optics
