// Parses dates and decimal days without rounding.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace toliman::ingest {

constexpr int64_t kSecond = 1000000000, kDay = 86400 * kSecond; // ns
constexpr int64_t kDayOf1970 = 40587, kFirstDayOfUtc = 41317;   // 1970-01-01 and 1972-01-01, MJD

// Calendar day (MJD) and nanoseconds since its beginning.
struct DayTime {
    int64_t day, ns;
    bool has_time; // not only a date
    bool has_zone; // the time ends with Z or an offset of 0 from UTC
};

// The one parser of dates of all readers: YYYY-MM-DD or YYYY-DDD (day of the year) of a day that exists, then perhaps T
// or one blank and hh:mm:ss[.s...], truncated to the nanosecond, then perhaps Z, +00:00, +0000, +00 or the same with -.
// Second 60 is accepted at the end of any day (a leap second), so that ns may exceed 86400 s.
std::optional<DayTime> parse_date(std::string_view text) noexcept;

// The offset from UTC at the end of a time, "+01:00"; empty for none.
std::string_view offset_of(std::string_view text) noexcept;

// Whether the text is a date and nothing else; whether it begins with one.
bool is_bare_date(std::string_view text) noexcept;
bool begins_with_date(std::string_view text) noexcept;

// The length of the first field of a text whose fields are separated by blanks and tabs: a date and a time that one
// blank separates are one field.
size_t first_field(std::string_view text) noexcept;

// The unit of the last digit of a date, of a time or of a number of days, ns: a day, a second, 1e-3 s and so on. Days
// of fewer than 4 places are taken as exact to 1 s, not as rounded.
int64_t date_resolution(std::string_view text) noexcept;
int64_t days_resolution(std::string_view text) noexcept;

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
