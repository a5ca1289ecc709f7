// The mission's side file: one JSON object a frame.
#pragma once
#include <string>
#include <vector>

#include "downlink/arrival.hpp"

namespace cli {

struct SideLine {
    FrameFacts facts;
    double host_s = 0;  // the host's clock
    std::string why;    // empty: the line is good
    bool named = false; // session, region and frame id can be read, whatever else is wrong
};

// Of sessions and regions of interest; a Failure that begins with `where`.
void check_name(const std::string &name, const std::string &where);

// Exactly the eight keys of formats.md; whole numbers to their last digit.
SideLine read_side_line(const std::string &line);

// All lines of a file; one that may go on being written has its last line left out while that has no newline.
std::vector<SideLine> read_side_file(const std::string &path, bool growing);

} // namespace cli
