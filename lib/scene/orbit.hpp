// The orbit of a visual binary: position of star B relative to star A on the sky.
#pragma once

namespace toliman {

constexpr double kDaysPerYear = 365.25; // Julian

// Campbell elements of B's motion about A. node_deg is the position angle of a node, periastron_deg the angle from that
// node to B's periastron in the direction of motion. Positions on the sky do not depend on which of the two nodes it
// is: adding 180 deg to both angles changes nothing. At inclinations below 90 deg position angles increase.
struct Orbit {
    double period_years, semi_major_arcsec, eccentricity, inclination_deg, node_deg, periastron_deg;
    double epoch; // of a passage through periastron, Julian year
};

// Alpha Centauri AB: Akeson et al. 2021, AJ 162, 14.
constexpr Orbit kAlphaCen = {79.762, 17.4930, 0.51947, 79.2430, 205.073, 231.519, 1955.564};

struct RelativePosition {
    double separation_arcsec, position_angle_deg; // of B from A, north through east, in (-180, 180] deg
};

// The position `years` (Julian) after the epoch of periastron; negative: before it.
RelativePosition position_on_orbit(const Orbit &orbit, double years) noexcept;

} // namespace toliman
