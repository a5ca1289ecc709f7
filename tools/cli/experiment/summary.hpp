// What the rows of an experiment come to: medians over seeds, and the controls.
#pragma once
#include <string>
#include <vector>

#include "experiment/campaign.hpp"

namespace cli {

struct Rung { // a method at an amplitude
    std::string method;
    double amplitude_px = 0;
    size_t seeds = 0, found = 0;
    double period_error = 0, log10_fap = 0; // medians; relative
    double slope = 0, efficiency = 0;       // medians, by regression on the truth
    double expected_log10_fap = 0;          // of a method at the bound
};

struct Control { // a method on frames without signal
    std::string method;
    size_t series = 0, frames = 0, alarms = 0;
    double uniformity = 0;               // of the FAPs, Kolmogorov-Smirnov
    double sigma_px = 0, efficiency = 0; // medians over seeds; sigma over the slope
    double bias_px = 0, slope = 0;       // means
};

struct TableSummary {
    const Table *table = nullptr;
    double crb_px = 0, threshold_px = 0, pca_threshold_px = 0;
    std::vector<Rung> rungs;
    std::vector<Control> controls; // none where no series without signal were asked for
};

std::vector<TableSummary> summarise(const Campaign &campaign, const Journal &journal);

// |period / true period - 1|.
double period_error(const Campaign &campaign, const Row &row);
// A period that counts: log10 FAP below kFound, and it is the signal's within 5 %.
bool found(const Campaign &campaign, const Row &row);
// Cramer-Rao bound over the scatter, both in px.
double efficiency(const Table &table, const Row &row);

} // namespace cli
