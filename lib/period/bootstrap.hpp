// Bootstrap: highest peaks of resampled series, which contain no periodic signal.
#pragma once
#include "base/progress.hpp"
#include "period/peak.hpp"

namespace toliman::period {

struct Bootstrap {
    uint64_t seed = 0;
    unsigned workers = 0; // 0: one per processor
    Progress progress;
};

// Given     the samples that were pushed
// Computed  peaks[count]: log10(1 - P) of the highest peak of `count` resamplings, ascending: the strongest peak first.
//           A resampling keeps the times and draws a value with its sigma for each, with replacement. Resampling i is
//           the same for every number of workers and every count. A resampling of equal values has power 0.
// Reference as in astropy; VanderPlas (2018), ApJS 236, 16, section 7.4.2.3
void bootstrap(const Stream &stream, const Samples &samples, const Bootstrap &options, double *peaks, size_t count);

} // namespace toliman::period
