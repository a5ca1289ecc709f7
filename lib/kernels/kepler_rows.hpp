// Positions and velocities on a Kepler orbit at many times, and products of rows of doubles.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kRowLanes = 16;               // lengths of rows are multiples
constexpr double kMostEccentricKepler = 0.991; // largest eccentricity

struct KeplerOrbit {
    double frequency;    // cycles per unit of time
    double anomaly;      // mean anomaly at time 0, cycles
    double eccentricity; // in [0, kMostEccentricKepler]
};

struct KeplerKernels {
    // Given     t [n], |frequency t + anomaly| < 2^51
    // Returned  x = cos E - e and y = sqrt(1 - e^2) sin E: distance in units of the semi-major axis, towards periastron
    //           and 90 deg ahead
    // Notes     within 1e-13; the same bits on every instruction set
    void (*position)(const KeplerOrbit &orbit, const double *t, size_t n, double *x, double *y) noexcept;
    // Given     as position
    // Returned  x = cos nu + e, y = sin nu with the true anomaly nu
    // Notes     as position, within 1e-12
    void (*velocity)(const KeplerOrbit &orbit, const double *t, size_t n, double *x, double *y) noexcept;
    // Given     rows [count][n], x [n], y [n]; n a multiple of kRowLanes
    // Returned  out [count][2]: sums of rows[i] x and rows[i] y
    // Notes     the same bits on every instruction set
    void (*products)(const double *rows, size_t count, const double *x, const double *y, size_t n,
                     double *out) noexcept;
};
TOLIMAN_ISA_DECLARE(KeplerKernels, kepler)

} // namespace toliman::kernels
