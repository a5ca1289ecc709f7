// Tables of on-target windows.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/leap_seconds.hpp"

namespace toliman::ingest {

struct OnTargetWindow {
    int64_t start_ns, end_ns; // TAI
};

// Reads the windows of a table, at least one, increasing and without overlap. Status::not_found, Status::format with
// file and line.
std::vector<OnTargetWindow> read_on_target(const std::string &path, const LeapSeconds &leap_seconds);

} // namespace toliman::ingest
