// The results of an experiment: medians over the seeds, and the controls.
#pragma once
#include <string>

#include "experiment/campaign.hpp"

namespace cli {

// experiment.json, schema toliman-experiment/1; its tables in Markdown; CSV with one row per method and series of
// frames.
struct ExperimentReport {
    std::string json, markdown, csv;
};
ExperimentReport report_of(const Campaign &campaign, const Journal &journal);

} // namespace cli
