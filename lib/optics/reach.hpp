// How far stars and frames get: along an orbit, by systematics and by the signal.
#pragma once
#include "optics/light.hpp"

namespace toliman::optics {

double farthest_of(const Signal &signal) noexcept; // px, to either side
// What a disturbance can make of a frame of the cadence.
double reach_of(const Disturbance &disturbance, const Cadence &cadence) noexcept;
double span_days(const Cadence &cadence) noexcept; // between the first and the last frame

// Fastest motion of a star along its orbit, px a day; 0 where the stars stand still.
double orbit_px_a_day(const Scene &scene, const Light &light);
// The light with each star as far from the frame's axis, in x and in y, as its orbit takes it through the cadence.
Light farthest_on_orbit(const Scene &scene, const Light &light);
// How far systematics can move a star of that light.
double wandering_px(const Scene &scene, const Light &light) noexcept;
// Farther out by these and the signal.
Light farthest_out(const Scene &scene, const Light &on_orbit);

} // namespace toliman::optics
