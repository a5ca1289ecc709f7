// ERFA: calendar and leap seconds. Days are Modified Julian Days.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

namespace toliman::erfa {

// Day of a date of the Gregorian calendar; empty if the date does not exist.
std::optional<int64_t> day_of(int year, int month, int day) noexcept;

struct LeapSecond {
    int64_t day;     // from 0 h UTC of this day on,
    int32_t tai_utc; // TAI - UTC, s
};

struct LeapSecondTable {
    std::vector<LeapSecond> rows; // from 1972 on
    int64_t expires;              // first day of the years that ERFA calls dubious: leap seconds may be missing
};

// The table that is built into ERFA, read at the first call. eraSetLeapSeconds does not change it afterwards.
const LeapSecondTable &leap_seconds();

} // namespace toliman::erfa
