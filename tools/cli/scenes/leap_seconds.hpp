// Leap seconds: those of the library, or of a file.
#pragma once
#include "common/common.hpp"

#include <toliman/ingest.h>

namespace CLI {
class App;
}

namespace cli {

// A leap-seconds.list, or the table of the library for "".
struct LeapSeconds {
    explicit LeapSeconds(const std::string &path = "");
    std::vector<toliman_leap_second> rows;
    int64_t expires = 0; // MJD
};

// Warns once in a process if dates of UTC were converted that the leap seconds of the command do not cover: those of
// its option --leap-seconds, or of the library.
void warn_of_expiry(const CLI::App &command, Progress &progress);

} // namespace cli
