// Dates in files of states.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "ingest/time_scale.hpp"

namespace toliman::sky {

// A line of a file, for messages.
struct Place {
    const char *path;
    int line;
};

// YYYY-MM-DDThh:mm:ss[.s...] or YYYY-DDDThh:mm:ss[.s...], with a final Z in UTC only, to nanoseconds of TAI. name: of
// the keyword or column. Status::format with place and name.
int64_t parse_epoch(std::string_view text, ingest::Scale scale, const ingest::LeapSeconds &leap_seconds,
                    const Place &place, const char *name);

// YYYY-MM-DDThh:mm:ss[.s...] of TAI.
std::string date_text(int64_t tai_ns);

} // namespace toliman::sky
