// False alarm probabilities of a peak, as logarithms: they never underflow.
#pragma once
#include <cstdint>

namespace toliman::period {

enum class Fap : int32_t { baluev, naive, single, sequential };

// What they depend on beside the power. Floating and fixed mean count alike.
struct Sampling {
    int64_t count;         // samples N >= 5
    double last_frequency; // the grid's highest, f_max
    double time_variance;  // weighted variance of the times
};

// Time span of an even coverage with this variance: N dt for N times dt apart.
double baseline(double time_variance) noexcept;

constexpr double kLeastLogResidual = -4900; // log10(1 - P) of a power that counts as 1

// Given     log10_residual in [kLeastLogResidual, 0]: log10(1 - P) of the "standard" power P
// Returned  log10 of the chance that noise alone has this power or more
//           single      at one frequency told beforehand: (1 - P)^((N - 3)/2)
//           naive       somewhere on the grid, were its frequencies M = f_max baseline independent ones:
//                       1 - (1 - single)^M. Too small, by 3 at 0.01: between independent frequencies there are higher
//                       powers
//           baluev      somewhere on the grid, an upper bound: with W = f_max sqrt(4 pi var t),
//                       tau = gamma(N - 1) W (1 - P)^((N - 4)/2) sqrt((N - 1) P/2), 1 - (1 - single) exp(-tau)
//           sequential  somewhere on the grid now or at any earlier or later number of samples: see fap.cpp
// Reference Baluev (2008), MNRAS 385, 1279, equations 5 and 6; single and naive as in astropy
double log10_fap(Fap method, const Sampling &sampling, double log10_residual) noexcept;

// Given     log10_fap in [that of kLeastLogResidual, 0]
// Returned  log10(1 - P) of the highest power that has this FAP
double log10_level(Fap method, const Sampling &sampling, double log10_fap) noexcept;

} // namespace toliman::period
