// Method: the calendar date of a day counts from 0000-03-01, so that a leap day is the last day of a year.
#include "ingest/epoch.hpp"

#include <optional>

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr int64_t kDaysBefore1970 = 719468; // since 0000-03-01
constexpr int64_t kDaysOf400Years = 146097;

// YYYY-MM-DD of a Modified Julian Day.
std::string calendar_date(int64_t day) {
    const int64_t days = day - kDayOf1970 + kDaysBefore1970;
    const int64_t era = (days >= 0 ? days : days - (kDaysOf400Years - 1)) / kDaysOf400Years;
    const int64_t of_era = days - era * kDaysOf400Years;
    const int64_t year_of_era = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
    const int64_t of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    const int64_t month = (5 * of_year + 2) / 153; // 0 = March
    const int64_t day_of_month = of_year - (153 * month + 2) / 5 + 1;
    const int64_t year = year_of_era + 400 * era + (month >= 10 ? 1 : 0);
    char text[64];
    print_text(text, sizeof text, "%04lld-%02lld-%02lld", static_cast<long long>(year),
               static_cast<long long>(month < 10 ? month + 3 : month - 9), static_cast<long long>(day_of_month));
    return text;
}

} // namespace

int64_t parse_epoch(std::string_view text, Scale scale, const LeapSeconds &leap_seconds, const TextPlace &place,
                    const char *name) {
    constexpr size_t kLongest = 64;
    const std::string shown(text.substr(0, kLongest));
    const std::optional<DayTime> date = text.size() < kLongest ? parse_date(text) : std::nullopt;
    Status status = Status::format;
    if (date && date->has_time) {
        try {
            return parse_time(shown.c_str(), TimeFormat::iso, scale, leap_seconds);
        } catch (const Error &error) {
            status = error.status();
        }
    }
    if (status == Status::range)
        fail(Status::format, "{%s}:%d: %s = \"%s\": must be from %s to 2099-12-31", place.path, place.line, name,
             shown.c_str(), first_date(scale));
    fail(Status::format,
         "{%s}:%d: %s = \"%s\": must be an existing time YYYY-MM-DDThh:mm:ss.s or YYYY-DDDThh:mm:ss.s, with a final Z "
         "or +00:00 in UTC only",
         place.path, place.line, name, shown.c_str());
}

std::string date_text(int64_t tai_ns) {
    const int64_t rest = tai_ns % kDay; // days times kDay may overflow
    const int64_t days = tai_ns / kDay - (rest < 0 ? 1 : 0), ns = rest < 0 ? rest + kDay : rest;
    const int64_t seconds = ns / kSecond;
    char time[64];
    size_t length = print_text(time, sizeof time, "T%02d:%02d:%02d.%09lld", static_cast<int>(seconds / 3600),
                               static_cast<int>(seconds / 60 % 60), static_cast<int>(seconds % 60),
                               static_cast<long long>(ns % kSecond));
    while (time[length - 1] == '0')
        length--;
    length -= time[length - 1] == '.' ? 1 : 0;
    return calendar_date(kDayOf1970 + days) + std::string(time, length);
}

} // namespace toliman::ingest
