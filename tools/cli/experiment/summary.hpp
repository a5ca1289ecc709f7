// Summary of an experiment: medians over the seeds, and the controls.
#pragma once
#include <string>
#include <vector>

#include "experiment/campaign.hpp"

namespace cli {

struct LadderRow { // a method at one amplitude
    std::string method;
    double amplitude_px = 0;
    size_t seeds = 0, found = 0;
    double period_error = 0, log10_fap = 0; // medians; relative
    double slope = 0, efficiency = 0;       // medians, by regression on the true displacement
    double expected_log10_fap = 0;          // of a method at the Cramer-Rao bound
};

struct Control { // a method on series without signal
    std::string method;
    size_t series = 0, frames = 0, alarms = 0;
    double uniformity = 0;               // p-value of the FAPs against the uniform distribution, Kolmogorov-Smirnov
    double sigma_px = 0, efficiency = 0; // medians over the seeds; sigma is divided by the slope
    double bias_px = 0, slope = 0;       // means
};

struct TableSummary {
    const Table *table = nullptr;
    double crb_px = 0, threshold_px = 0, pca_threshold_px = 0;
    std::vector<LadderRow> ladder;
    std::vector<Control> controls; // empty without series without signal
};

std::vector<TableSummary> summarise(const Campaign &campaign, const Journal &journal);

// |period / true period - 1|.
double period_error(const Campaign &campaign, const Row &row);
// Whether the signal was found: log10 FAP below kFound, and the period within 5 % of the true one.
bool found(const Campaign &campaign, const Row &row);
// Cramer-Rao bound over the scatter, both in px.
double efficiency(const Table &table, const Row &row);

// The results as JSON, as Markdown, and as CSV with one row per method and series of frames.
std::string report_json(const Campaign &campaign, const std::vector<TableSummary> &summaries);
std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries);
std::string report_csv(const Campaign &campaign, const Journal &journal);

} // namespace cli
