// State folders of `toliman track`, of shards or of several passes, into one.
#pragma once
#include <string>
#include <vector>

#include "downlink/setup_options.hpp"

namespace cli {

// Into `out`, which must not be there yet; nothing is left of it after an error.
void merge_folders(const std::vector<std::string> &folders, const std::string &out, bool salvage, SetupOptions &setup,
                   Progress &progress);

} // namespace cli
