// Warnings about frequency grids that do not suit the times of the samples.
#pragma once
#include "series/periodogram.hpp"

namespace cli {

// Warns of a grid step above 1/(5 T), with T from the sums alone, and of inaccurate powers, each once: `warned` holds
// the flags of toliman_period_sampling that were reported.
void warn_while_following(const toliman::periodogram &periodogram, uint32_t &warned, Progress &progress);
// All warnings, also of a peak at the edge. series: NULL if only the sums are known; then the median time step is
// unknown.
void warn_of_grid(const Periodogram &periodogram, const Series *series, Progress &progress);

} // namespace cli
