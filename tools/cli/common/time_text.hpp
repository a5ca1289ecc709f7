// Parses times of FITS headers to the nanosecond.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace cli {

// A decimal number times `unit`, rounded to the nearest integer, halves away from zero; the first 24 digits count.
// Empty if the text is not a number or the result exceeds 64 bits.
std::optional<int64_t> times_unit(const std::string &text, int64_t unit);

// Days in nanoseconds: whole days are exact, the fraction is rounded to the nanosecond. Empty beyond 100,000 days.
std::optional<int64_t> ns_of_days(double days);

// Calendar day (MJD) and nanoseconds since its beginning.
struct DayTime {
    int64_t day, ns;
};

// Parses YYYY-MM-DD or YYYY-MM-DDThh:mm:ss[.s...] of a day that exists, truncated to the nanosecond. Second 60 is
// accepted at the end of any day (a leap second), so that ns may exceed 86400 s.
std::optional<DayTime> read_date(const std::string &text);

} // namespace cli
