// The instruments of a series: offsets and jitters.
#pragma once
#include "series/series.hpp"

namespace cli {

using Instruments = std::vector<toliman_measure_instrument>;

// Those of a series with several, in a fit of its functions, and of a sinusoid unless the frequency is 0; otherwise
// none.
Instruments instruments_of(const Series &series, double frequency = 0);

// Adds the jitter of each instrument whose residuals its sigmas do not explain.
void add_jitters(const Instruments &instruments, Series &series);

// A line for each; "" for none. unit: of the values, may be empty.
std::string text_of(const Instruments &instruments, const std::string &unit);
std::vector<Json> json_of(const Instruments &instruments);

} // namespace cli
