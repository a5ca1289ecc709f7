// Reads whole time series: text, JSON Lines, or a .npy table.
#pragma once
#include <string>
#include <vector>

#include "series/sample_reader.hpp"

namespace cli {

struct Series {
    std::string name;                // the file's name in messages
    std::vector<double> t, y, sigma; // sigma is empty if the file has none
    std::string warning = {};        // "" for none
    std::string time_scale = {};     // as SampleParser
};

// All samples of a file, at least one; also of .npy files, float64 [samples][2 or 3].
Series read_series(const std::string &name, const SampleOptions &options = {});

} // namespace cli
