// Method: ERFA keeps its table of leap seconds in global variables, which it initialises at the first use without a
// lock. The table is therefore read once, under the lock of a static variable, and never replaced: eraSetLeapSeconds
// would change it for the whole process. Reference: Essential Routines for Fundamental Astronomy,
// https://github.com/liberfa/erfa.
#include "backend/erfa.hpp"

#include <erfa.h>
#include <erfaextra.h>

namespace toliman::erfa {

namespace {

constexpr int kFirstYear = 1972; // earlier, TAI - UTC was not a whole number of seconds
constexpr int kLastYear = 2099;

std::vector<LeapSecond> read_rows() {
    eraLEAPSECOND *rows = nullptr;
    const int count = eraGetLeapSeconds(&rows);
    std::vector<LeapSecond> table;
    for (int i = 0; i < count; i++)
        if (const auto day = day_of(rows[i].iyear, rows[i].month, 1); day && rows[i].iyear >= kFirstYear)
            table.push_back({*day, static_cast<int32_t>(rows[i].delat)});
    return table;
}

int64_t first_dubious_day() noexcept {
    int year = kFirstYear;
    for (double seconds = 0; year <= kLastYear && eraDat(year, 1, 1, 0, &seconds) == 0;)
        year++;
    return *day_of(year, 1, 1);
}

} // namespace

std::optional<int64_t> day_of(int year, int month, int day) noexcept {
    double zero = 0, days = 0;
    if (eraCal2jd(year, month, day, &zero, &days) != 0)
        return std::nullopt;
    return static_cast<int64_t>(days);
}

const LeapSecondTable &leap_seconds() {
    static const LeapSecondTable table = {read_rows(), first_dubious_day()};
    return table;
}

} // namespace toliman::erfa
