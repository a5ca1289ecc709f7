// Method: with E from Kepler's equation at the mean anomaly 2 pi t/P + phase, and the argument w,
//     displacement = amplitude ((cos E - e) sin w + sqrt(1 - e^2) sin E cos w),
// which is r/a sin(true anomaly + w). Only the projection on the binary's axis is modelled, as if the orbital plane
// contained it.
#include "scene/wobble.hpp"

#include <cmath>

#include "base/constants.hpp"
#include "kernels/kepler.hpp"

namespace toliman {

namespace {

// Nominal GM of the Sun and the Earth (IAU 2015 resolution B3, m^3/s^2), astronomical unit (IAU 2012 resolution B2, m).
constexpr double kSun = 1.3271244e20, kEarth = 3.986004e14, kAstronomicalUnit = 149597870700.0;
constexpr double kSecondsPerDay = 86400;

double mass_fraction(const Planet &planet) noexcept {
    const double planet_sun = planet.mass_earth * (kEarth / kSun);
    return planet_sun / (planet.star_mass_sun + planet_sun);
}

} // namespace

double reflex_uas(const Planet &planet) noexcept {
    return 1e6 * mass_fraction(planet) * planet.semi_major_au / planet.distance_pc; // 1 au at 1 pc is 1 arcsec
}

double period_days(const Planet &planet) noexcept {
    const double axis = planet.semi_major_au * kAstronomicalUnit;
    const double gm = planet.star_mass_sun * kSun + planet.mass_earth * kEarth;
    return 2 * kPi * std::sqrt(axis * axis * axis / gm) / kSecondsPerDay;
}

double displacement_px(const Signal &signal, double days) noexcept {
    if (signal.amplitude_px == 0)
        return 0;
    const double mean = 2 * kPi * (std::fmod(days, signal.period_days) / signal.period_days) + signal.phase_rad;
    const double e = signal.eccentricity, argument = signal.argument_deg * kPi / 180;
    if (e == 0)
        return signal.amplitude_px * std::sin(mean + argument);
    const double anomaly = kernels::kepler(mean, e);
    return signal.amplitude_px * ((std::cos(anomaly) - e) * std::sin(argument) +
                                  std::sqrt((1 - e) * (1 + e)) * std::sin(anomaly) * std::cos(argument));
}

} // namespace toliman
