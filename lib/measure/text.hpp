// Reads a whole series: a text table, JSON Lines, an array of JSON objects, or a .npy table.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/series.hpp"
#include "measure/series.hpp"

namespace toliman::measure {

struct Text {
    Series series;
    ingest::Unit unit; // of y, as the file states it
    std::vector<std::string> warnings;
};

// options: as for the lines of a stream; their name begins the messages. Status::format for a malformed line, and if
// there are no samples, or values that seem to stand for missing ones; Status::mismatch if there are no such columns.
Text read_text(std::string_view bytes, const ingest::SeriesOptions &options);

// Sets kind and unit of the series, none and 0: those that the file states. Status::argument if they contradict it.
void set_unit(std::optional<Kind> kind, double unit, Text &text);

} // namespace toliman::measure
