// Periodograms that go on: sums saved and taken up, samples followed as they come.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "series/periodogram.hpp"

namespace cli {

struct StreamOptions {
    std::string file; // empty: no samples, only the state
    std::vector<std::string> columns;
    std::string from_state, save_state;
    std::optional<FrequencyGrid> grid; // without a state
    SumOptions sums;                   // likewise
    // Prints a line of JSON after each sample from the fifth on; passes over lines that are no samples and tells of
    // them, at the end as a failure if strict; saves every minute and whatever ends it. Otherwise the first such line
    // is an error, and only a run that ends well saves.
    bool follow = false, strict = false;
};

// Pushes the samples onto the state, or onto a new one, and saves it.
toliman::periodogram stream_samples(const StreamOptions &options, Progress &progress);

} // namespace cli
