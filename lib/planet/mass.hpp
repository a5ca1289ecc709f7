// From the amplitude of a star to the mass of its planet.
#pragma once

namespace toliman::planet {

constexpr double kEarthsPerSun = 332946.0487;

// Units of a series; 0: unknown.
struct Units {
    bool velocity;
    double days;            // per unit of t
    double unit;            // arcsec or m/s per unit of y
    double parallax_arcsec; // of a separation
    double star_mass[2];    // solar masses

    bool knows_mass(int star) const noexcept {
        return unit > 0 && star_mass[star] > 0 && (velocity || parallax_arcsec > 0);
    }
    // Mass in Earth masses, times g or sin i, of a planet of star 0 or 1; NaN if units are unknown.
    double mass(int star, double period, double eccentricity, double amplitude) const noexcept;
    // The inverse.
    double amplitude(int star, double period, double eccentricity, double mass) const noexcept;
};

// Velocity in m/s of a star that moves by one unit of y, of a separation, times one radian per unit of t.
double velocity_of_motion(const Units &units) noexcept;

} // namespace toliman::planet
