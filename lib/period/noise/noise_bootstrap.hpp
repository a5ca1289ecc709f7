// Moving-block bootstrap of a series with correlated noise.
#pragma once
#include "period/noise/noise_search.hpp"

namespace toliman::period {

struct NoiseBootstrap {
    uint64_t seed = 0;
    size_t block = 0;     // consecutive samples; 0: n^(1/3)
    unsigned workers = 0; // 0: one per processor
    Progress progress;
};

// Given     the model at the correlation that whitens the residuals
// Computed  peaks [count]: log10(1 - P) of the highest power of `count` resamplings, ascending. Resampling i is the
// same
//           for every number of workers and every count. A resampling of equal values has power 0.
void bootstrap_noise(const NoiseModel &model, const NoiseGrid &grid, const NoiseBootstrap &options, double *peaks,
                     size_t count);

} // namespace toliman::period
