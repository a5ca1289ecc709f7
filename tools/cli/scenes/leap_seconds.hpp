// Leap seconds: those of the library, or of a file.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/ingest.h>

namespace cli {

// A leap-seconds.list, or the table of the library for "".
struct LeapSeconds {
    explicit LeapSeconds(const std::string &path = "");
    std::vector<toliman_leap_second> rows;
    int64_t expires = 0; // MJD
};

} // namespace cli
