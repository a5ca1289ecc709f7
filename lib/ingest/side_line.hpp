// A line of the side file: the description of one frame.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "frame/spread.hpp"

namespace toliman::ingest {

constexpr size_t kLongestLine = 4096;
constexpr uint32_t kLargestSide = 65536;         // pixels
constexpr int64_t kLongestExposure = 1000000000; // s
constexpr size_t kMostIntervals = 64;            // with 17 digits per number they fit in a line

struct SideLine {
    int64_t frame_id = 0, stamp_ns = 0, dropped = 0;
    double host_s = 0;                      // host clock
    int64_t number = 0;                     // of the line, from 1; 0 in a batch
    int64_t restarts = 0;                   // of the camera before this frame, see restarts.hpp
    int64_t clock_shift_ns = 0;             // added to stamp_ns, it continues the clock of before the restarts
    int64_t window_row = 0, window_col = 0; // of the first pixel on the detector
    bool is_restart = false;                // first line after a restart
    uint32_t rows = 0, cols = 0;            // in [1, kLargestSide]
    size_t pixel_bytes = 0;                 // of its key dtype, 2 or 4; 0 without
    std::shared_ptr<const std::vector<double>> on_target_s; // start and end of each interval in turn; empty: unknown
    double exposure_s = 0;                                  // 0: as all frames of the pair
    std::shared_ptr<const Spread> spread;                   // of a sum of frames
    const char *session = nullptr, *roi = nullptr;          // of the set of names
    const char *unknown_key = nullptr;                      // the first one, of the set of names; NULL: none
    bool has_key = false; // session, roi and frame_id are valid, also if `error` is not empty
    std::string error;    // empty if the line is valid
};

// Parses a JSON object with the keys of formats.md. Names are added to `names`. A malformed line is not
// an exception: `error` describes it. exposure_s: length of the exposure unless the line has it, 0 if it
// is unknown.
SideLine parse_side_line(const std::string &text, double exposure_s, std::set<std::string> &names);

} // namespace toliman::ingest
