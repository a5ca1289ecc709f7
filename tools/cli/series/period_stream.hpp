// Periodograms of samples that arrive one by one: sums are saved and continued.
#pragma once
#include "series/periodogram.hpp"
#include "series/series_options.hpp"

namespace cli {

struct PeriodStreamOptions {
    std::string file; // empty: no samples, only the state
    SampleOptions samples;
    std::string from_state, save_state;
    std::optional<FrequencyGrid> grid; // only without a state
    SumOptions sums;                   // only without a state
    NuisanceOptions nuisance;          // only without a state
    // follow: prints a JSON line after each sample from the fifth on; skips lines that are not samples and reports
    // them, at the end as a failure if strict; saves every minute and at the end, also after an error. Without follow
    // the first such line is an error, and only a successful run saves.
    bool follow = false, strict = false;
};

// Pushes the samples to the state, or to a new one, and saves it.
toliman::periodogram stream_samples(const PeriodStreamOptions &options, Progress &progress);

} // namespace cli
