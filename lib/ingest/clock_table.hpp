// Clock tables: pairs of camera time and TAI.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/progress.hpp"

namespace toliman::ingest {

struct ClockPair {
    int64_t camera_ns, tai_ns;
};

// Reads lines camera_ns,tai_ns, at least one, increasing in both columns. Warns once if the rate of a pair differs from
// 1 by more than 1 %. Status::not_found, Status::format with file and line.
std::vector<ClockPair> read_clock_table(const std::string &path, const Log &log);

} // namespace toliman::ingest
