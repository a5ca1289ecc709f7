// Dates in text files and in messages.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "ingest/time_scale.hpp"

namespace toliman::ingest {

// A line of a file, for messages.
struct TextPlace {
    const char *path;
    int line;
};

// A date of parse_date with its time, with a zone in UTC only, to nanoseconds of TAI. name: of the keyword or column.
// Status::format with place and name.
int64_t parse_epoch(std::string_view text, Scale scale, const LeapSeconds &leap_seconds, const TextPlace &place,
                    const char *name);

// YYYY-MM-DDThh:mm:ss[.s...] of TAI.
std::string date_text(int64_t tai_ns);

} // namespace toliman::ingest
