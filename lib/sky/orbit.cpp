// Method: mean anomaly M = 2 pi t/P, eccentric anomaly E from Kepler's equation E - e sin E = M, position in the
// orbital plane
//     x = a (cos E - e) (towards periastron),   y = a sqrt(1 - e^2) sin E,
// rotated by the argument of periastron w to p = x cos w - y sin w (towards the node) and q = x sin w + y cos w, by
// the inclination i to p, q cos i and q sin i (away from the observer), and by the node to north and east. The
// derivatives follow from dE/dM = 1/(1 - e cos E) and dE/de = sin E/(1 - e cos E). No derivative of the separation
// exceeds that of the position in space: with the largest distance a (1 + e), the largest speed
// 2 pi a/P sqrt((1 + e)/(1 - e)), sin^2 E/(1 - e cos E) <= 2 and sqrt(1 - e^2) sin E/(1 - e cos E) <= 1.
//
// Reference: Green, Spherical Astronomy, ch. 19. Sign of the line of sight: B recedes at the ascending node.
#include "sky/orbit.hpp"

#include <array>
#include <cmath>

#include "base/constants.hpp"
#include "base/hash.hpp"
#include "kernels/kepler.hpp"

namespace toliman::sky {

namespace {

struct InPlane {
    double sine, cosine; // of the eccentric anomaly
    double root;         // sqrt(1 - e^2)
    double x, y;         // from A, towards periastron and 90 deg ahead
};

InPlane in_plane(const Orbit &orbit, double years) noexcept {
    const double mean = 2 * kPi * (std::fmod(years, orbit.period_years) / orbit.period_years);
    const double e = orbit.eccentricity, anomaly = kernels::kepler(mean, e);
    InPlane at = {std::sin(anomaly), std::cos(anomaly), std::sqrt((1 - e) * (1 + e)), 0, 0};
    at.x = orbit.semi_major_arcsec * (at.cosine - e);
    at.y = orbit.semi_major_arcsec * at.root * at.sine;
    return at;
}

// Rotates by the argument of periastron: towards the node, and 90 deg ahead in the plane.
struct Rotated {
    double p, q;
};
Rotated rotate(const Orbit &orbit, double x, double y) noexcept {
    const double angle = orbit.periastron_deg * kDegree, cosine = std::cos(angle), sine = std::sin(angle);
    return {x * cosine - y * sine, x * sine + y * cosine};
}

} // namespace

double OrbitPosition::separation_arcsec() const noexcept {
    return std::hypot(north_arcsec, east_arcsec);
}

double OrbitPosition::position_angle_deg() const noexcept {
    return std::atan2(east_arcsec, north_arcsec) / kDegree;
}

OrbitPosition position_on_orbit(const Orbit &orbit, double year) noexcept {
    const InPlane at = in_plane(orbit, year - orbit.epoch);
    const auto [p, q] = rotate(orbit, at.x, at.y);
    const double node = orbit.node_deg * kDegree, inclination = orbit.inclination_deg * kDegree;
    const double across = q * std::cos(inclination);
    return {p * std::cos(node) - across * std::sin(node), p * std::sin(node) + across * std::cos(node),
            q * std::sin(inclination)};
}

OrbitPartials partials_on_orbit(const Orbit &orbit, double year) noexcept {
    const double years = year - orbit.epoch, a = orbit.semi_major_arcsec, e = orbit.eccentricity;
    const InPlane at = in_plane(orbit, years);
    const double inclination = orbit.inclination_deg * kDegree;
    const double flat = std::cos(inclination), steep = std::sin(inclination);
    const auto [p, q] = rotate(orbit, at.x, at.y);
    const double across = q * flat, separation = std::hypot(p, across);
    OrbitPartials partials = {};
    const auto set = [&, p = p](size_t element, double unit, double dp, double dacross, double daway) {
        partials.separation[element] = unit * (p * dp + across * dacross) / separation;
        partials.angle[element] = unit * (p * dacross - across * dp) / (separation * separation);
        partials.away[element] = unit * daway;
    };
    const auto set_in_plane = [&](size_t element, double unit, double dx, double dy) {
        const Rotated change = rotate(orbit, dx, dy);
        set(element, unit, change.p, change.q * flat, change.q * steep);
    };
    const double slope = 1 / (1 - e * at.cosine);                                 // dE/dM
    const double dx = -a * at.sine * slope, dy = a * at.root * at.cosine * slope; // by the mean anomaly
    const double revolution = 2 * kPi / orbit.period_years;
    set_in_plane(0, -revolution * years / orbit.period_years, dx, dy);
    set_in_plane(1, 1 / a, at.x, at.y);
    set_in_plane(2, 1, -a * (at.sine * at.sine * slope + 1), a * at.sine * (at.root * at.cosine * slope - e / at.root));
    set(3, kDegree, 0, -q * steep, q * flat);
    partials.angle[4] = kDegree;
    set(5, kDegree, -q, p * flat, p * steep);
    set_in_plane(6, -revolution, dx, dy);
    return partials;
}

void bound_partials(const Orbit &orbit, double bounds[kElements]) noexcept {
    constexpr double kFirstYear = 1899, kLastYear = 2101; // with light time and time scales
    const double a = orbit.semi_major_arcsec, e = orbit.eccentricity, root = std::sqrt((1 - e) * (1 + e));
    const double farthest = a * (1 + e), speed = 2 * kPi * a / orbit.period_years * std::sqrt((1 + e) / (1 - e));
    const double years = std::fmax(std::fabs(kFirstYear - orbit.epoch), std::fabs(kLastYear - orbit.epoch));
    const double largest[kElements] = {speed * years / orbit.period_years,
                                       1 + e,
                                       a * std::hypot(3, 1 + e / root),
                                       farthest * kDegree,
                                       0,
                                       farthest * kDegree,
                                       speed};
    for (size_t i = 0; i < kElements; i++) {
        int exponent;
        std::frexp(1.25 * largest[i], &exponent); // 1.25: for the factor
        bounds[i] = std::ldexp(1.0, exponent);
    }
}

uint64_t digest_of(const Orbit &orbit) noexcept {
    uint64_t hash = kFnvOffset;
    for (const auto element : kElementOf)
        hash = fnv1a(std::array<double, 1>{orbit.*element}, hash);
    return hash;
}

} // namespace toliman::sky
