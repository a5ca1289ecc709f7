// A whole periodogram of a series at once: what `run` and `period` share.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

#include "csv.hpp"

namespace cli {

struct FrequencyGrid {
    double f0, df;
    int64_t nf;
};

// f0 = 1.5/T, df = 1/(10 T) up to 1/(2 median dt); T the time span plus one median step.
FrequencyGrid default_grid(const std::vector<double> &times);

struct Periodogram {
    toliman::periodogram handle;
    toliman_period_peak peak; // refined against the samples
};

// Pushes every sample one by one and fits the highest peak.
Periodogram find_period(const Series &series, const FrequencyGrid &grid, bool fixed_mean);

std::vector<double> power_of(const Periodogram &periodogram, int64_t nf);

} // namespace cli
