// Tables of states in CSV.
#pragma once
#include <string_view>
#include <vector>

#include "ingest/text_lines.hpp"
#include "sky/ephemeris.hpp"

namespace toliman::sky {

// One segment: a header with the names of the columns, then a state per line. first: the first line that is not blank;
// lines: those after it. Status::format with file, line and reason.
std::vector<Segment> read_ephemeris_table(ingest::TextLines &lines, std::string_view first,
                                          const ingest::LeapSeconds &leap_seconds, const Log &log);

} // namespace toliman::sky
