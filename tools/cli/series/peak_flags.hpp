// Peaks that something other than a planet often causes: flags TOLIMAN_PERIOD_LONG and _ANNUAL of a peak.
#pragma once
#include <cstdint>
#include <string>

#include "common/json.hpp"
#include "common/terminal.hpp"

namespace cli {

// ", long period" and ", annual" after the numbers of a peak.
std::string flags_text(uint32_t flags);
// Sets long_period and annual.
void set_flags(uint32_t flags, Json &json);
// One sentence for each flag. hint: option that fits a trend, ": --trend"; "" if there is one.
// is_dated: the times are dates; plain numbers are taken as days.
void warn_of_peak(uint32_t flags, const std::string &hint, bool is_dated, Progress &progress);

} // namespace cli
