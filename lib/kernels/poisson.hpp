// Exact Poisson counts and normal variates from a counter-based generator: a count depends on (seed, stream, frame,
// pixel) alone, not on order, blocks or threads.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Selects a sequence of random numbers: Philox-4x32-10, key = seed, counter = (pixel, draw + 2^16 stream, frame).
struct NoiseKey {
    uint64_t seed;
    uint64_t frame;
    uint32_t stream; // < 2^16; one per use of a seed, so that uses are independent
};
constexpr uint32_t kStreamPhotons = 0, kStreamReadout = 1, kStreamWeights = 2, kStreamFlat = 3, kStreamSystematics = 4,
                   kStreamAtoms = 5, kStreamShuffle = 6, kStreamBootstrap = 7, kStreamResponse = 8, kStreamProbe = 9,
                   kStreamPosterior = 10, kStreamInjection = 11, kStreamInjectionNoise = 12;

struct PoissonKernels {
    // Given     mean [count], each in [0, 1e12]; first_pixel, the pixel number of mean[0] (below 2^32)
    // Returned  counts [count], exact Poisson variates as integers in double
    // Notes     Inversion for means below 10, transformed rejection above. Uses only sqrt, rounding and its own
    //           logarithm: the same bits on every instruction set.
    // Reference Hormann (1993), Insurance: Mathematics and Economics 12, 39; Salmon et al. (2011), SC '11
    void (*poisson)(const double *mean, size_t count, uint64_t first_pixel, NoiseKey key, double *counts) noexcept;

    // Given     count, first_pixel
    // Returned  normals [count], independent standard normal variates, within 1e-15 of the exact Box-Muller transform
    void (*gaussian)(size_t count, uint64_t first_pixel, NoiseKey key, double *normals) noexcept;
};
TOLIMAN_ISA_DECLARE(PoissonKernels, poisson)

} // namespace toliman::kernels
