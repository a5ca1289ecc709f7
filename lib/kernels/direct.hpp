// Periodogram sums at a few frequencies over many samples, blocked and compensated.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kDirectLanes = 16; // frequencies per call

// With u = 1 - cos 2 pi f t and v = sin 2 pi f t: sums of w u, w v, w u^2, w u v, w v^2, x u, x v.
enum DirectSum { kU, kV, kUU, kUV, kVV, kXU, kXV, kDirectSums };

struct DirectSamples {
    const double *t_high, *t_low; // unevaluated sums
    const double *w, *x;
    size_t n;
};

struct DirectKernels {
    // Given     half_high, half_low [kDirectLanes], f/2 as unevaluated sums, |f t| < 2^51; samples
    // Returned  high, low [kDirectSums][kDirectLanes], unevaluated sums, increased by the sums over the samples
    // Notes     u and v have a relative error below 1e-15, however small they are. Sums within a block are plain, sums
    //           of blocks are compensated. The same bits on every instruction set.
    void (*direct)(const double *half_high, const double *half_low, const DirectSamples &samples, double *high,
                   double *low) noexcept;
};
TOLIMAN_ISA_DECLARE(DirectKernels, direct)

} // namespace toliman::kernels
