// The signal of a planet on a Kepler orbit, as a linear combination of two shapes, four if the axis turns, and two more
// of velocities.
#pragma once
#include <array>
#include <cstddef>

#include "base/buffer.hpp"
#include "planet/series.hpp"

namespace toliman::planet {

constexpr size_t kMostAmplitudes = 6;
using Amplitudes = std::array<double, kMostAmplitudes>;

// frequency f in cycles per unit of t; mean anomaly at the time reference, cycles; the star that has the planet, 0 or
// 1, which only velocities tell.
struct Orbit {
    double frequency, eccentricity, anomaly;
    int star = 0;

    bool operator==(const Orbit &other) const noexcept {
        return frequency == other.frequency && eccentricity == other.eccentricity && anomaly == other.anomaly &&
               star == other.star;
    }
};

// Signal = c_0 x + c_1 y, and + c_2 x' + c_3 y' if the axis turns: x and y are the position on the orbit towards
// periastron and 90 deg ahead, along the axis, x' and y' the same across the axis. With velocities, the last two are
// those of the coordinate away from the observer, of which the velocities are the derivative.
struct Planet {
    Orbit orbit;
    Amplitudes amplitudes;
};

// Writes the shapes at the measurements to shapes [amplitudes][rows]; in the padding, those of the time reference.
void set_shapes(const Series &series, const Orbit &orbit, double *shapes) noexcept;

// The shapes at the measurements as functions of a fit, without priors.
std::vector<Function> shape_functions(const Series &series, const Orbit &orbit);

// The signal at other times t [n], with these position angles, deg; NULL: those of the mean axis.
Buffer<double> signal_at(const Series &series, const Planet &planet, const double *t, const double *position_angle_deg,
                         size_t n);

// The signal at the measurements [rows].
Buffer<double> signal_of(const Series &series, const Planet &planet);

// Amplitude along the mean axis, in units of the series, and the angle of periastron, rad.
double amplitude_of(const Amplitudes &amplitudes) noexcept;
double periastron_of(const Amplitudes &amplitudes) noexcept;

} // namespace toliman::planet
