// Largest excursions of the stars during the cadence: by the orbit, the systematics and the signal.
#pragma once
#include "optics/light.hpp"

namespace toliman::optics {

double max_signal_px(const Signal &signal) noexcept; // in either direction
// Largest value of a disturbance at 4 sigma, drift over the cadence included.
double four_sigma_of(const Disturbance &disturbance, const Cadence &cadence) noexcept;

// Fastest motion of a star along its orbit, px per day; 0 if the stars do not follow the orbit.
double orbit_px_per_day(const Scene &scene, const Light &light);
// The light with each star at its largest offset from the optical axis, in x and in y separately, during the cadence.
Light farthest_on_orbit(const Scene &scene, const Light &light);
// Largest shift of a star by systematics, at 4 sigma.
double systematic_shift_px(const Scene &scene, const Light &light) noexcept;
// The same light, with the stars farther out by systematics and the signal.
Light farthest_with_shifts(const Scene &scene, const Light &on_orbit);

} // namespace toliman::optics
