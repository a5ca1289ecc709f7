// The orbit of a visual binary: position of star B relative to star A.
#pragma once
#include <cstddef>
#include <cstdint>

namespace toliman::sky {

constexpr double kDaysPerYear = 365.25; // Julian

// Campbell elements of B's motion about A. node_deg is the position angle of the ascending node, at which B recedes
// from the observer, periastron_deg the angle from there to B's periastron in the direction of motion. With the other
// node, both angles 180 deg larger, north and east are the same and away has the other sign. At inclinations below
// 90 deg position angles increase.
struct Orbit {
    double period_years, semi_major_arcsec, eccentricity, inclination_deg, node_deg, periastron_deg;
    double epoch; // of a passage through periastron, Julian year
};
constexpr double Orbit::*kElementOf[] = {
    &Orbit::period_years, &Orbit::semi_major_arcsec, &Orbit::eccentricity, &Orbit::inclination_deg,
    &Orbit::node_deg,     &Orbit::periastron_deg,    &Orbit::epoch};
constexpr size_t kElements = 7;
// FNV-1a hash of the elements.
uint64_t digest_of(const Orbit &orbit) noexcept;

// B relative to A: tangential plane and line of sight, as angles at the distance of the system.
struct OrbitPosition {
    double north_arcsec, east_arcsec, away_arcsec;

    double separation_arcsec() const noexcept;
    double position_angle_deg() const noexcept; // north through east, in (-180, 180]
};

// The position at a Julian year.
OrbitPosition position_on_orbit(const Orbit &orbit, double year) noexcept;

// Derivatives by the elements, per unit of each.
struct OrbitPartials {
    double separation[kElements]; // of separation_arcsec(); 0 by the node
    double angle[kElements];      // of the position angle, rad
    double away[kElements];       // of away_arcsec
};
OrbitPartials partials_on_orbit(const Orbit &orbit, double year) noexcept;

// Upper bounds of the derivatives of the position of B, which no derivative of a separation exceeds, from 1900 to 2100:
// powers of two, so that every machine computes the same.
void bound_partials(const Orbit &orbit, double bounds[kElements]) noexcept;

} // namespace toliman::sky
