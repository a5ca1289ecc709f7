#include "optics/wobble.hpp"

#include <cmath>

#include "kernels/kepler.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
// IAU 2015 resolution B3 (nominal GM of the Sun and the Earth, m^3/s^2) and 2012 B2 (m)
constexpr double kSun = 1.3271244e20, kEarth = 3.986004e14, kAstronomicalUnit = 149597870700.0;
constexpr double kSecondsPerDay = 86400;

double planet_share(const Planet &planet) noexcept {
    const double planet_sun = planet.mass_earth * (kEarth / kSun);
    return planet_sun / (planet.star_mass_sun + planet_sun);
}

} // namespace

double reflex_uas(const Planet &planet) noexcept {
    return 1e6 * planet_share(planet) * planet.semi_major_au / planet.distance_pc; // 1 au at 1 pc is 1 arcsec
}

double period_days(const Planet &planet) noexcept {
    const double axis = planet.semi_major_au * kAstronomicalUnit;
    const double pull = planet.star_mass_sun * kSun + planet.mass_earth * kEarth;
    return 2 * kPi * std::sqrt(axis * axis * axis / pull) / kSecondsPerDay;
}

double displacement_px(const Signal &signal, double days) noexcept {
    if (signal.amplitude_px == 0)
        return 0;
    const double mean = 2 * kPi * (std::fmod(days, signal.period_days) / signal.period_days) + signal.phase_rad;
    const double e = signal.eccentricity, argument = signal.argument_rad;
    if (e == 0)
        return signal.amplitude_px * std::sin(mean + argument);
    const double anomaly = kernels::kepler(mean, e);
    return signal.amplitude_px * ((std::cos(anomaly) - e) * std::sin(argument) +
                                  std::sqrt((1 - e) * (1 + e)) * std::sin(anomaly) * std::cos(argument));
}

} // namespace toliman::optics
