// Peaks of the caller's own samples when nothing periodic can be left in them.
#pragma once
#include "base/progress.hpp"
#include "period/peak.hpp"

namespace toliman::period {

struct Bootstrap {
    uint64_t seed = 0;
    unsigned workers = 0; // 0 = one a processor
    Progress progress;
};

// Given     the samples that were pushed
// Computed  peaks[count]: log10(1 - P) of the highest peak of `count` resamplings, ascending: the strongest first. A
//           resampling keeps the times and draws to each a value with its sigma, with replacement; number i draws the
//           same whatever the workers and the count. One of values that are all equal has the power 0.
// Reference as in astropy; VanderPlas (2018), ApJS 236, 16, section 7.4.2.3
void bootstrap(const Stream &stream, const Samples &samples, const Bootstrap &options, double *peaks, size_t count);

} // namespace toliman::period
