// Sums of a few frequencies over many samples, blocked and compensated.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kDirectLanes = 16; // frequencies at once

// With u = 1 - cos 2 pi f t and v = sin 2 pi f t: means of these, weighted by w or by x.
enum DirectSum { kU, kV, kUU, kUV, kVV, kXU, kXV, kDirectSums };

struct DirectSamples {
    const double *t_high, *t_low; // unevaluated sums
    const double *w, *x;
    size_t n;
};

struct DirectKernels {
    // Given     half_high, half_low [kDirectLanes], f/2 as unevaluated sums, |f t| < 2^51; samples
    // Returned  high, low [kDirectSums][kDirectLanes], plus the sums, as unevaluated sums
    // Notes     u and v come from half the phase, within 1e-15 of themselves however small they are. Sums of a
    //           block are plain, sums of blocks carry their rounding error along. The same bits on every instruction
    //           set.
    void (*direct)(const double *half_high, const double *half_low, const DirectSamples &samples, double *high,
                   double *low) noexcept;
};
TOLIMAN_ISA_DECLARE(DirectKernels, direct)

} // namespace toliman::kernels
