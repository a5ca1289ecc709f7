// The table of --on-target: windows in which the telescope points at the stars.
#pragma once
#include "scenes/leap_seconds.hpp"

namespace cli {

struct TargetWindow {
    int64_t start_ns, end_ns; // TAI
};

// In order of time; they do not overlap.
std::vector<TargetWindow> read_on_target(const std::string &path, const LeapSeconds &leap_seconds);

// The parts of an exposure within the windows: start and end of each in turn, TAI.
std::vector<int64_t> parts_of(const std::vector<TargetWindow> &windows, int64_t start_ns, int64_t end_ns);

} // namespace cli
