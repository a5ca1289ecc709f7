// CCSDS Orbit Ephemeris Messages in key-value notation.
#pragma once
#include <string_view>
#include <vector>

#include "ingest/text_lines.hpp"
#include "sky/ephemeris.hpp"

namespace toliman::sky {

// first: the first line, CCSDS_OEM_VERS = 1.0, 2.0 or 3.0; lines: those after it. Status::format with file, line and
// reason.
std::vector<Segment> read_oem(ingest::TextLines &lines, std::string_view first, const ingest::LeapSeconds &leap_seconds,
                              const Log &log);

} // namespace toliman::sky
