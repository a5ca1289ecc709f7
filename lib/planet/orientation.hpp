// Size and orientation of an orbit, which velocities determine together with separations.
#pragma once
#include "planet/signal.hpp"

namespace toliman::planet {

struct Orientation {
    double axis;            // semi-major axis of the star's orbit, units of y; along the axis A -> B without velocities
    double inclination_deg; // in [0, 90], of the orbit or of its mirror image; NaN without velocities
    double node_deg;        // ascending node from the axis A -> B, in [0, 180], to either side; NaN without velocities
};

Orientation orientation_of(const Series &series, const Planet &planet) noexcept;

} // namespace toliman::planet
