// Remarks upon grids that do not suit the samples' times.
#pragma once
#include "series/periodogram.hpp"

namespace cli {

// Of a grid coarser than 1/(5 T), T from the sums alone; false while it is not.
bool remark_if_coarse(const toliman::periodogram &periodogram, Progress &progress);
// All, and of a peak at the edge. series: NULL where the sums are all there is; then the median time step is not known.
void remark(const Periodogram &periodogram, const Series *series, Progress &progress);

} // namespace cli
