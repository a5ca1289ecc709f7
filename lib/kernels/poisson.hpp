// Exact Poisson counts, counter-based: the count of (seed, stream, frame, pixel) is the same in any order.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Which random numbers: Philox-4x32-10 with the seed as key and (pixel, draw and stream, frame) as counter.
struct NoiseKey {
    uint64_t seed;
    uint64_t frame;
    uint32_t stream; // < 2^16; keeps the uses of one seed apart
};
constexpr uint32_t kStreamPhotons = 0, kStreamReadout = 1, kStreamWeights = 2, kStreamFlat = 3, kStreamSystematics = 4,
                   kStreamAtoms = 5, kStreamShuffle = 6, kStreamBootstrap = 7;

struct PoissonKernels {
    // Given     mean [count], each in [0, 1e12]; first_pixel, the pixel number of mean[0] (below 2^32)
    // Returned  counts [count], exact Poisson variates as integers in double
    // Notes     inversion below 10, transformed rejection with a hat checked to dominate above. Uses sqrt, floor and
    //           own log only: the same bits on every instruction set.
    void (*poisson)(const double *mean, size_t count, uint64_t first_pixel, NoiseKey key, double *counts) noexcept;

    // Given     count, first_pixel
    // Returned  normals [count], independent standard normal variates (to 1e-15 of the exact quantile or transform)
    void (*gaussian)(size_t count, uint64_t first_pixel, NoiseKey key, double *normals) noexcept;
};
TOLIMAN_ISA_DECLARE(PoissonKernels, poisson)

} // namespace toliman::kernels
