// A line of the side file: the description of one frame.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

namespace toliman::ingest {

constexpr size_t kLongestLine = 4096;

struct SideLine {
    int64_t frame_id = 0, stamp_ns = 0, dropped = 0;
    double host_s = 0;                             // host clock
    uint32_t rows = 0, cols = 0;                   // in [1, 65536]
    const char *session = nullptr, *roi = nullptr; // of the set of names
    bool has_key = false;                          // session, roi and frame_id are valid, also if `error` is not empty
    std::string error;                             // empty if the line is valid
};

// Parses a JSON object with exactly the eight keys of formats.md. Names are added to `names`. A malformed line is not
// an exception: `error` describes it.
SideLine parse_side_line(const std::string &text, std::set<std::string> &names);

} // namespace toliman::ingest
