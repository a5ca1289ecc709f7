// The table that tells TAI by the camera's clock.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/terminal.hpp"

namespace cli {

// Pairs camera_ns,tai_ns of a CSV file, one after the other, both rising; 0,0 for "camera", and none for "". Warns of
// a clock that goes 1 % faster or slower than TAI: columns are exchanged, or times are no nanoseconds.
std::vector<int64_t> read_clock(const std::string &path, Progress &progress);

} // namespace cli
