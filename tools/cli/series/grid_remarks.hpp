// Remarks upon grids that do not suit the samples' times.
#pragma once
#include "series/periodogram.hpp"

namespace cli {

// Of a grid coarser than 1/(5 T), T from the sums alone, and of inaccurate powers; each once: `told` has the flags of
// toliman_period_sampling that were remarked upon.
void remark_while_following(const toliman::periodogram &periodogram, uint32_t &told, Progress &progress);
// All, and of a peak at the edge. series: NULL where the sums are all there is; then the median time step is not known.
void remark(const Periodogram &periodogram, const Series *series, Progress &progress);

} // namespace cli
