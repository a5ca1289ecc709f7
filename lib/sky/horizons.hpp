// Vector tables of JPL Horizons, in CSV.
#pragma once
#include <vector>

#include "ingest/text_lines.hpp"
#include "sky/ephemeris.hpp"

namespace toliman::sky {

// Whether the text has the mark of a table, a line $$SOE.
bool is_horizons(std::string_view text) noexcept;

// lines: from the line after `first` on. Status::format with file, line and reason.
std::vector<Segment> read_horizons(ingest::TextLines &lines, std::string_view first,
                                   const ingest::LeapSeconds &leap_seconds, const Log &log);

} // namespace toliman::sky
