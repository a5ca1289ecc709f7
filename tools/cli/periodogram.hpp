// A whole periodogram of a series at once: what `run` and `period` share.
#pragma once
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "series.hpp"
#include "terminal.hpp"

namespace cli {

struct FrequencyGrid {
    double f0, df;
    int64_t nf;
};

// f0 = 1.5/T, df = 1/(10 T) up to 1/(2 median dt); T the time span plus one median step. An error names both where that
// makes more than 2e6 frequencies.
FrequencyGrid default_grid(const Series &series);

struct Periodogram {
    toliman::periodogram handle;
    double time_offset;       // where the peak's phase counts from: the first time
    toliman_period_peak peak; // refined against the samples
    bool at_edge() const noexcept { return (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0; }
};

// Pushes every sample one by one and fits the highest peak; a signal stops it between two samples.
Periodogram find_period(const Series &series, const FrequencyGrid &grid, bool fixed_mean, Progress &progress);

// A periodogram file of `period --save-state`.
toliman::periodogram load_state(const std::string &path);
void save_state(const toliman::periodogram &periodogram, const std::string &path);

constexpr const char kEdgeRemark[] =
    "the peak stands at the edge of the grid and the period may lie beyond: --f0, --df and --nf give another grid";

// In TOLIMAN_POWER_STANDARD or another.
std::vector<double> power_of(const toliman::periodogram &periodogram, int64_t nf, uint32_t normalisation = 0);

} // namespace cli
