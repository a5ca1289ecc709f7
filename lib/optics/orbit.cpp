#include "optics/orbit.hpp"

#include <cmath>

#include "kernels/kepler.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;

} // namespace

// The Thiele-Innes way: the place in the orbit's plane, turned by the three angles.
Place place_on(const Orbit &orbit, double years) noexcept {
    const double mean = 2 * kPi * (std::fmod(years, orbit.period_years) / orbit.period_years);
    const double e = orbit.eccentricity, anomaly = kernels::kepler(mean, e);
    const double x = orbit.semi_major_arcsec * (std::cos(anomaly) - e); // towards periastron
    const double y = orbit.semi_major_arcsec * std::sqrt((1 - e) * (1 + e)) * std::sin(anomaly);
    const double periastron = orbit.periastron_deg * kDegree, node = orbit.node_deg * kDegree;
    const double along = x * std::cos(periastron) - y * std::sin(periastron); // the node's direction
    const double across =
        (x * std::sin(periastron) + y * std::cos(periastron)) * std::cos(orbit.inclination_deg * kDegree);
    const double north = along * std::cos(node) - across * std::sin(node);
    const double east = along * std::sin(node) + across * std::cos(node);
    return {std::hypot(north, east), std::atan2(east, north) / kDegree};
}

} // namespace toliman::optics
