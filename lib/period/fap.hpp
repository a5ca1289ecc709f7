// False alarm probabilities (FAP) of a peak and detection thresholds, as logarithms: they never underflow.
#pragma once
#include <cstdint>

namespace toliman::period {

enum class Fap : int32_t { baluev, naive, single, sequential };

// What the FAP depends on in addition to the power. A fixed mean is treated like a floating one.
struct Sampling {
    int64_t count;         // samples N >= 5, N >= K + 4
    double last_frequency; // the grid's highest, f_max
    double time_variance;  // weighted variance of the times
    int64_t functions = 1; // K, functions fitted without the sinusoid: the mean and nuisance functions without a prior
};

// Returns the time span of uniform coverage with this variance of the times: N dt for N times dt apart.
double baseline(double time_variance) noexcept;

constexpr double kMinLogResidual = -4900; // log10(1 - P) of the largest power distinguished from 1

// Given     log10_residual in [kMinLogResidual, 0]: log10(1 - P) of the "standard" power P
// Returned  log10 of the probability that white noise alone reaches this power
//           single      at one frequency chosen in advance: (1 - P)^((N - K - 2)/2)
//           naive       anywhere on the grid, assuming M = f_max baseline independent frequencies: 1 - (1 - single)^M.
//                       Underestimates the FAP (about 3x too small at 0.01), since powers between independent
//                       frequencies may be higher
//           baluev      anywhere on the grid, an upper bound: with W = f_max sqrt(4 pi var t),
//                       tau = gamma(N - K) W (1 - P)^((N - K - 3)/2) sqrt((N - K) P/2), 1 - (1 - single) exp(-tau)
//           sequential  anywhere on the grid at this or any other interim query: see fap.cpp
// Reference Baluev (2008), MNRAS 385, 1279, equations 5 and 6; single and naive as in astropy
double log10_fap(Fap method, const Sampling &sampling, double log10_residual) noexcept;

// Given     log10_fap in [that of kMinLogResidual, 0]
// Returned  the detection threshold: log10(1 - P) of the power with this FAP, the highest one if there are several
double log10_threshold(Fap method, const Sampling &sampling, double log10_fap) noexcept;

} // namespace toliman::period
