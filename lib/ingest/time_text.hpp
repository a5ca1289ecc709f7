// Parses dates and decimal days without rounding.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace toliman::ingest {

// Calendar day (MJD) and nanoseconds since its beginning.
struct DayTime {
    int64_t day, ns;
};

// Parses YYYY-MM-DD or YYYY-MM-DDThh:mm:ss[.s...] of a day that exists, truncated to the nanosecond. Second 60 is
// accepted at the end of any day (a leap second), so that ns may exceed 86400 s.
std::optional<DayTime> parse_date(std::string_view text) noexcept;

// A number of days; digits after the 24th, and after the 23rd behind the point, are ignored.
class Days {
  public:
    // Parses a decimal number with an optional sign and an optional exponent after e or d.
    static std::optional<Days> parse(std::string_view text) noexcept;
    Days plus_half() const noexcept;
    // Whole days, rounded down; -1 for every number below 0, INT64_MAX if there are more.
    int64_t whole() const noexcept { return whole_; }
    // The rest of a day of `length` nanoseconds, at most 1e14, rounded to the nearest.
    int64_t rest(int64_t length) const noexcept;

  private:
    __extension__ using Wide = __int128;

    Days() = default;
    Days(Wide value, int exponent) noexcept; // value times 10^exponent

    int64_t whole_ = 0;
    Wide part_ = 0, scale_ = 1; // the rest is part_/scale_ of a day
};

} // namespace toliman::ingest
