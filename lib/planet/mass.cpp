// Method: Kepler's third law and the distances from the centre of mass, in au, days and solar masses:
//     a^3 = (k/2 pi)^2 (M + m) P^2,    a_star = m/(M + m) a,
// so that m/(M + m)^(2/3) = a_star/((k/2 pi)^(2/3) P^(2/3)), with a_star from the amplitude: that of a separation over
// the parallax, or K sqrt(1 - e^2) P/(2 pi). The equation for m is solved by iteration, whose error falls by at least
// a third in each step. m in M + m is the mass times g or sin i.
#include "planet/mass.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman::planet {

namespace {

constexpr double kGauss = 0.01720209895; // rad/day, for a mass of 1 and 1 au
constexpr double kAstronomicalUnit = 149597870700.0, kDay = 86400;

// Semi-major axis of a relative orbit of total mass 1, au.
double unit_orbit(double days) noexcept {
    return std::cbrt(std::pow(kGauss / (2 * kPi) * days, 2));
}

// Amplitude in units of y of a star at 1 au from the centre of mass.
double per_au(const Units &units, double days, double eccentricity) noexcept {
    const double velocity = 2 * kPi * kAstronomicalUnit / (days * kDay * std::sqrt(1 - eccentricity * eccentricity));
    return (units.velocity ? velocity : units.parallax_arcsec) / units.unit;
}

} // namespace

double Units::mass(int star, double period, double eccentricity, double amplitude) const noexcept {
    if (!knows_mass(star))
        return NAN;
    const double span = period * days, star_axis = amplitude / per_au(*this, span, eccentricity);
    const double ratio = star_axis / unit_orbit(span);
    double mass = 0;
    for (int i = 0; i < 200; i++) {
        const double next = ratio * std::pow(star_mass[star] + mass, 2.0 / 3);
        const bool settled = std::fabs(next - mass) <= 1e-15 * next;
        mass = next;
        if (settled)
            break;
    }
    return mass * kEarthsPerSun;
}

double Units::amplitude(int star, double period, double eccentricity, double mass) const noexcept {
    if (!knows_mass(star))
        return NAN;
    const double span = period * days, sun = mass / kEarthsPerSun;
    return sun / std::pow(star_mass[star] + sun, 2.0 / 3) * unit_orbit(span) * per_au(*this, span, eccentricity);
}

double velocity_of_motion(const Units &units) noexcept {
    return units.unit / units.parallax_arcsec * kAstronomicalUnit / (units.days * kDay);
}

} // namespace toliman::planet
