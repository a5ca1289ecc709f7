// Tables in CSV whose header names the columns: their fields and times.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "ingest/text_lines.hpp"
#include "ingest/time_scale.hpp"

namespace toliman::ingest {

constexpr size_t kMostFields = 16, kNoColumn = kMostFields;

using Fields = std::array<std::string_view, kMostFields>;

// The fields of a line without comment; returns their number, of which at most 16 are kept.
size_t split_fields(std::string_view line, Fields &fields) noexcept;

std::string_view without_comment(std::string_view line) noexcept;

// The index of a name in a header of `count` fields, at most 16; kNoColumn if it is missing.
size_t column_of(std::string_view name, const Fields &header, size_t count) noexcept;

// What a column of times contains, the end of its name: dates, the first ones as in Scale, or integers of nanoseconds.
constexpr const char *kTimeKinds[] = {"utc", "tai", "tt", "tdb", "gps", "tai_ns"};

// A time of 1958 (UTC: 1972) to 2099 to nanoseconds of TAI. kind: index in kTimeKinds; name: of the column.
// Status::format with file, line and name.
int64_t time_of(std::string_view text, size_t kind, const char *name, const LeapSeconds &leap_seconds,
                const TextLines &lines);

} // namespace toliman::ingest
