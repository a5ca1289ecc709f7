// The results of an experiment as JSON, CSV and Markdown.
#pragma once
#include <string>

#include "experiment/summary.hpp"

namespace cli {

std::string report_json(const Campaign &campaign, const std::vector<TableSummary> &summaries);
std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries);
// One row per method and series of frames.
std::string report_csv(const Campaign &campaign, const Journal &journal);

} // namespace cli
