// The results of an experiment on paper: JSON, CSV, Markdown.
#pragma once
#include <string>

#include "experiment/summary.hpp"

namespace cli {

std::string report_json(const Campaign &campaign, const std::vector<TableSummary> &summaries);
std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries);
// A row for each method on each series of frames.
std::string report_csv(const Campaign &campaign, const Journal &journal);

} // namespace cli
