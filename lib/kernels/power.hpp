// Lomb-Scargle power from the sums of kernels/push.hpp, vectorised over frequencies.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Quantities common to all frequencies.
struct PowerShared {
    double weight;              // W > 0
    int64_t samples;            // in [W, 2^32)
    double mean_high, mean_low; // weighted mean Wy/W as an unevaluated sum
    double spread;              // weighted variance about the mean, at least (mean/kFarthestMean)^2
    bool fixed_mean;
};

// Smallest determinant cc ss - cs^2, in units of W^4, for which double precision gives the power to 1e-13.
constexpr double kLeastDeterminant = 0.05;
constexpr double kNeedsMore = -1; // returned instead of the power below it: the caller needs extended precision
// Largest supported |mean|, in standard deviations.
constexpr double kFarthestMean = 0x1p15;

struct PowerKernels {
    // Given     lo, hi, the eight single-limb sums in the order of `Sum`, each [n]; shared
    // Returned  power [n], in [0, 1], within 1e-13 of exact arithmetic on the same sums, or kNeedsMore; the result is
    //           the number of kNeedsMore
    // Notes     C1, S1, C2 and S2 are rounded to 2^-51 W (C1 and S1 to 2^-62 W where the mean exceeds 8 standard
    //           deviations, which takes 1.5 times as long), YC and YS to 2^-53, YCLow and YSLow to 2^-101 samples. The
    //           same bits on every instruction set.
    size_t (*power)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                    double *power) noexcept;

    // The same for double-limb sums, lo and hi [kSums]. YCLowest and YSLowest, at most 2^-101 samples, are ignored.
    size_t (*power_double_limb)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                                double *power) noexcept;

    // Given     values [n]
    // Returned  whether one is at least `limit`
    bool (*any_reaches)(const double *values, size_t n, double limit) noexcept;
};
TOLIMAN_ISA_DECLARE(PowerKernels, power)

} // namespace toliman::kernels
