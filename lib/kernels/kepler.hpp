// Kepler's equation.
#pragma once

namespace toliman::kernels {

// Given     mean_anomaly M, any finite value (rad), 0 <= eccentricity e < 1
// Returned  eccentric anomaly E in [-pi, pi] (rad): E - e sin E = M but for whole revolutions
// Notes     Within 4 units in the last place of E for every e up to the last double below 1 and every M, those near 0,
//           where E - e sin E cancels, and those of 1e300 included. Odd in M. NaN for M infinite or NaN.
//           On [0, pi] the left side rises and is convex, so that Newton's steps from above the root fall towards it
//           and cannot pass it: they end when rounding stops the fall. The start is at most 1.7 times the root; 7 steps
//           were the most seen, 64 are allowed.
// Reference Danby, Fundamentals of Celestial Mechanics, ch. 6
double kepler(double mean_anomaly, double eccentricity) noexcept;

} // namespace toliman::kernels
