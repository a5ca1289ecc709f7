// Reads a whole series: text, JSON Lines, or a .npy table.
#pragma once
#include <string>
#include <string_view>

#include "ingest/series.hpp"
#include "measure/series.hpp"

namespace toliman::measure {

struct Text {
    Series series;
    std::string warning; // "" for none
};

// options: as for the lines of a stream; their name begins the messages. Status::format for a malformed line, and if
// there are no samples; Status::mismatch if there are no such columns.
Text read_text(std::string_view bytes, const ingest::SeriesOptions &options);

} // namespace toliman::measure
