// Periodograms that go on: sums saved and taken up, samples followed as they come.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "periodogram.hpp"

namespace cli {

struct StreamOptions {
    std::string file; // empty: no samples, only the state
    std::vector<std::string> columns;
    std::string from_state;
    std::optional<FrequencyGrid> grid; // without a state
    std::optional<double> value_bound, sigma_floor, sigma_ceiling;
    bool fixed_mean = false, follow = false;
};

// Pushes the samples onto the state, or onto a new one; with `follow` prints a line of JSON after each from the fifth
// on.
toliman::periodogram stream_samples(const StreamOptions &options, Progress &progress);

} // namespace cli
