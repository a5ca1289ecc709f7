// Lomb-Scargle power from the sums of kernels/push.hpp, many frequencies at once.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// What all frequencies share.
struct PowerShared {
    double weight;              // W > 0
    int64_t samples;            // in [W, 2^32)
    double mean_high, mean_low; // Wy/W as an unevaluated sum
    double spread;              // variance about the mean, at least that of kFarthestMean
    bool fixed_mean;
};

// Of cc ss - cs^2, W^4 times: below it doubles do not carry the power to 1e-13.
constexpr double kLeastDeterminant = 0.05;
constexpr double kNeedsMore = -1; // in place of such a power
// Standard deviations that the mean may be away from 0 at most.
constexpr double kFarthestMean = 0x1p15;

struct PowerKernels {
    // Given     lo, hi, the eight narrow sums in the order of `Sum`, each [n]; shared
    // Returned  power [n], in [0, 1], within 1e-13 of what exact arithmetic would make of the sums; or kNeedsMore, as
    //           often as the result says
    // Notes     C1, S1, C2 and S2 are rounded to 2^-51 W (2^-62 W where the mean is above 8 standard deviations, which
    //           takes half as long again), YC and YS to 2^-53, YCLow and YSLow to 2^-101 samples. The same bits on
    //           every instruction set.
    size_t (*power)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                    double *power) noexcept;

    // The same of wide sums, all kSums of them. YCLowest and YSLowest, 2^-101 samples at most, are left out.
    size_t (*power_double_limb)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                                double *power) noexcept;
};
TOLIMAN_ISA_DECLARE(PowerKernels, power)

} // namespace toliman::kernels
