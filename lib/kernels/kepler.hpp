// Solution of Kepler's equation.
#pragma once

namespace toliman::kernels {

// Given     mean_anomaly M, any finite value (rad), 0 <= eccentricity e < 1
// Returned  eccentric anomaly E in [-pi, pi] (rad): E - e sin E = M up to whole revolutions
// Notes     Error below 4 units in the last place of E, for every e up to the largest double below 1 and every M,
//           including M near 0, where E - e sin E cancels, and M of 1e300. Odd in M. NaN for M infinite or NaN.
// Reference Danby, Fundamentals of Celestial Mechanics, ch. 6
double kepler(double mean_anomaly, double eccentricity) noexcept;

} // namespace toliman::kernels
