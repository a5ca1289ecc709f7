// Lomb-Scargle power from the sums of kernels/push.hpp, many frequencies at once.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// What all frequencies share.
struct PowerShared {
    double part;                // 1/W
    double mean_high, mean_low; // Wy/W as an unevaluated sum
    double spread;              // variance about the mean, > 0
    bool fixed_mean;
};

// Of cc ss - cs^2: below it double no longer carries 13 digits of the power.
constexpr double kLeastDeterminant = 0.01;
constexpr double kNeedsMore = -1; // in place of such a power

struct PowerKernels {
    // Given     lo, hi, the eight narrow sums in the order of `Sum`, each [n], of fewer than 2^34 samples; shared
    // Returned  power [n], in [0, 1], within 1e-13 of what exact arithmetic would make of the sums; or kNeedsMore
    // Notes     YC - mean C1 and YS - mean S1 are formed in double-double where the mean is above 64 standard
    //           deviations, else, as the rest, in double. The same bits on every instruction set.
    void (*power)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                  double *power) noexcept;
};
TOLIMAN_ISA_DECLARE(PowerKernels, power)

} // namespace toliman::kernels
