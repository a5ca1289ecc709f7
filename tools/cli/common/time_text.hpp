// Times as FITS headers write them, to the nanosecond.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace cli {

// A decimal number times `unit`, to the nearest whole number, halves away from zero; of its digits the first 24 count.
// None unless the text is such a number and the result fits.
std::optional<int64_t> times_unit(const std::string &text, int64_t unit);

// Days, of which the whole ones are exact and the rest is rounded to the nanosecond; none beyond 100,000.
std::optional<int64_t> ns_of_days(double days);

// Day (MJD) of the calendar and the nanoseconds since it began.
struct DayTime {
    int64_t day, ns;
};

// YYYY-MM-DD or YYYY-MM-DDThh:mm:ss[.s...], of a day that exists, cut to the nanosecond. A second 60 is taken at the
// end of any day, so that ns may lie beyond it.
std::optional<DayTime> read_date(const std::string &text);

} // namespace cli
