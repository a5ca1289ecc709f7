// Where a result comes from: command line, date and processor.
#pragma once
#include "common/common.hpp"

namespace cli {

// The model name that Linux reports, "unknown" if there is none.
std::string processor_name();

// Keys command (the words of this process's command line, quoted for a shell where necessary), date (UTC,
// YYYY-MM-DDThh:mm:ssZ) and processor.
Json provenance();

} // namespace cli
