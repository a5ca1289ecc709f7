// False alarm probability of a peak.
#pragma once
#include <cstdint>

namespace toliman::period {

// Given     log10_residual, log10(1 - P) of the "standard" power P, <= 0
//           count, samples N >= 5; last_frequency, the grid's highest; time_variance, weighted variance of the times
// Returned  log10 of the chance that pure noise peaks at P or above somewhere on the grid
// Reference Baluev (2008), MNRAS 385, 1279, equations 5 and 6 as in astropy: with W = f_max sqrt(4 pi var t),
//           tau = gamma(N - 1) W (1 - P)^((N - 4)/2) sqrt((N - 1) P/2), FAP = 1 - (1 - (1 - P)^((N - 3)/2)) exp(-tau)
// Notes     in logarithms where the FAP is small, so that it never underflows. Floating and fixed mean count alike.
double log10_fap_baluev(double log10_residual, int64_t count, double last_frequency, double time_variance) noexcept;

} // namespace toliman::period
