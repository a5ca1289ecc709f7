// The orbit of a visual binary: where star B stands seen from star A.
#pragma once

namespace toliman::optics {

constexpr double kDaysPerYear = 365.25; // Julian

// Elements of B's motion about A. node_deg is the position angle of a node and periastron_deg the angle from there to
// B's periastron in the direction of motion; which of the two nodes, the places on the sky do not tell: adding 180 deg
// to both angles changes nothing. Inclination below 90 deg: position angles grow.
struct Orbit {
    double period_years, semi_major_arcsec, eccentricity, inclination_deg, node_deg, periastron_deg;
    double epoch; // of a passage through periastron, Julian year
};

// Alpha Centauri AB: Akeson et al. 2021, AJ 162, 14.
constexpr Orbit kAlphaCen = {79.762, 17.4930, 0.51947, 79.2430, 205.073, 231.519, 1955.564};

struct Place {
    double separation_arcsec, position_angle_deg; // of B from A, north through east, in (-180, 180] deg
};

// The place `years` (Julian) after the epoch of periastron; negative ones are before it.
Place place_on(const Orbit &orbit, double years) noexcept;

} // namespace toliman::optics
