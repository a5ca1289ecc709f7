// A whole periodogram of a series at once: what `run` and `period` share.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

#include "csv.hpp"
#include "terminal.hpp"

namespace cli {

struct FrequencyGrid {
    double f0, df;
    int64_t nf;
};

// f0 = 1.5/T, df = 1/(10 T) up to 1/(2 median dt); T the time span plus one median step. An error names both where that
// makes more frequencies than a periodogram takes.
FrequencyGrid default_grid(const std::vector<double> &times);

struct Periodogram {
    toliman::periodogram handle;
    toliman_period_peak peak; // refined against the samples
};

// Pushes every sample one by one and fits the highest peak; a signal stops it between two samples.
Periodogram find_period(const Series &series, const FrequencyGrid &grid, bool fixed_mean, Progress &progress);

std::vector<double> power_of(const Periodogram &periodogram, int64_t nf);

} // namespace cli
