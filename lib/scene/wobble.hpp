// The signal: displacement of the moving star along the binary's axis, a sinusoid or the reflex motion due to a planet.
#pragma once
#include "scene/scene.hpp"

namespace toliman {

struct Planet {
    double mass_earth, semi_major_au; // of its orbit relative to the star
    double star_mass_sun, distance_pc;
};

// Semi-major axis of the star's orbit about the common barycentre, a m/(M + m), as an angle (microarcsec).
double reflex_uas(const Planet &planet) noexcept;
// Period by Kepler's third law, with the mass M + m.
double period_days(const Planet &planet) noexcept;

// Displacement `days` after time 0: the amplitude times r/a sin(true anomaly + argument), a sinusoid for eccentricity
// 0. Its mean over a period is -3/2 e sin(argument) amplitudes, because the star is slow far from periastron.
double displacement_px(const Signal &signal, double days) noexcept;

} // namespace toliman
