// The motion of the star that moves, along the binary's axis.
#pragma once
#include "optics/scene.hpp"

namespace toliman::optics {

struct Planet {
    double mass_earth, semi_major_au; // of its orbit relative to the star
    double star_mass_sun, distance_pc;
};

// Semi-major axis of the star's own orbit about the common barycentre, a m/(M + m), seen from the distance.
double reflex_uas(const Planet &planet) noexcept;
// Kepler's third law with M + m.
double period_days(const Planet &planet) noexcept;

// Displacement at a time: the amplitude times r/a sin(true anomaly + argument), the sinusoid for eccentricity 0. Its
// mean over a period is -3/2 e sin(argument) amplitudes, because a star is slow far from periastron.
double displacement_px(const Signal &signal, double days) noexcept;

} // namespace toliman::optics
