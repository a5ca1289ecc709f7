// Aliases of a peak as text, JSON and warning.
#pragma once
#include <string>
#include <vector>

#include <toliman/period_sampling.h>

#include "common/json.hpp"
#include "common/terminal.hpp"

namespace cli {

using Aliases = std::vector<toliman_period_alias>;

// Those of a peak at `frequency`; none outside the grid.
Aliases aliases_of(const toliman_period *periodogram, double frequency);
// A line for each alias that the samples do not tell from the peak, at most four; "" for none.
std::string text_of(const Aliases &aliases);
std::vector<Json> json_of(const Aliases &aliases);
// Warns if a slow change may cause the peak. hint: option that fits a trend, ": --trend"; "" if there is one.
void warn_of_aliases(const Aliases &aliases, const std::string &hint, Progress &progress);

} // namespace cli
