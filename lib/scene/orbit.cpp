// Method: mean anomaly M = 2 pi t/P, eccentric anomaly E from Kepler's equation E - e sin E = M, position in the
// orbital plane
//     x = a (cos E - e) (towards periastron),   y = a sqrt(1 - e^2) sin E,
// rotated by the argument of periastron, the inclination and the node to north and east (the Thiele-Innes constants).
#include "scene/orbit.hpp"

#include <cmath>

#include "base/constants.hpp"
#include "kernels/kepler.hpp"

namespace toliman {

namespace {

constexpr double kDegree = kPi / 180;

} // namespace

RelativePosition position_on_orbit(const Orbit &orbit, double years) noexcept {
    const double mean = 2 * kPi * (std::fmod(years, orbit.period_years) / orbit.period_years);
    const double e = orbit.eccentricity, anomaly = kernels::kepler(mean, e);
    const double x = orbit.semi_major_arcsec * (std::cos(anomaly) - e); // towards periastron
    const double y = orbit.semi_major_arcsec * std::sqrt((1 - e) * (1 + e)) * std::sin(anomaly);
    const double periastron = orbit.periastron_deg * kDegree, node = orbit.node_deg * kDegree;
    const double along = x * std::cos(periastron) - y * std::sin(periastron); // towards the node
    const double across =
        (x * std::sin(periastron) + y * std::cos(periastron)) * std::cos(orbit.inclination_deg * kDegree);
    const double north = along * std::cos(node) - across * std::sin(node);
    const double east = along * std::sin(node) + across * std::cos(node);
    return {std::hypot(north, east), std::atan2(east, north) / kDegree};
}

} // namespace toliman
