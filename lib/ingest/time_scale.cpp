// Method: a time is a day (MJD) and nanoseconds of that day. TAI follows by a constant, or for UTC by the seconds that
// TAI is ahead on that day. A fraction of a day of UTC counts the day's length, 86,401 s if it ends with a leap second,
// as in SOFA and astropy. The latest day of UTC is kept for the whole process, as every reader converts dates here: a
// program learns from it that its leap seconds have expired, whichever file the dates came from. TDB is treated as TT:
// they differ by less than 2 ms. Reference: SOFA Time Scale and Calendar Tools, http://www.iausofa.org.
#include "ingest/time_scale.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "base/error.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr int64_t kFirstDay = 36204, kEndDay = 88069;                         // 1958-01-01 and 2100-01-01
constexpr int64_t kHalfDayOfJd = 2400001;                                     // JD + 0.5 = MJD + 2400001
constexpr int64_t kAhead[] = {0, 0, -32184000000, -32184000000, 19000000000}; // TAI - scale, ns; UTC: leap seconds

bool in_range(int64_t day, Scale scale) noexcept {
    return day >= (scale == Scale::utc ? kFirstDayOfUtc : kFirstDay) && day < kEndDay;
}

thread_local int64_t last_day = 0;

// day is in range.
int64_t tai_of(int64_t day, int64_t ns, Scale scale, const LeapSeconds &leap_seconds) noexcept {
    if (scale == Scale::utc)
        last_day = std::max(last_day, day);
    const int64_t ahead =
        scale == Scale::utc ? leap_seconds.tai_utc(day).value_or(0) * kSecond : kAhead[static_cast<size_t>(scale)];
    return (day - kDayOf1970) * kDay + ns + ahead;
}

// Describes the error.
[[noreturn]] void fail_format(const char *text, TimeFormat format) {
    constexpr const char *kRules[] = {("YYYY-MM-DD or YYYY-DDD, alone or with Thh:mm:ss[.s...] (T or a blank), with a "
                                       "final Z or +00:00 in UTC only"),
                                      "a Modified Julian Day, a decimal number such as 61831.5",
                                      "a Julian Day, a decimal number such as 2461832.0"};
    fail(Status::format, "{text} = \"%.60s\": must be %s", text, kRules[static_cast<size_t>(format)]);
}

// A time whose offset from UTC is not 0 is refused, not converted: the scale of the others would be in doubt.
[[noreturn]] void fail_date(const char *text) {
    const std::string given = text;
    const std::string offset(offset_of(given));
    if (offset.empty() || !parse_date(std::string_view(given).substr(0, given.size() - offset.size())))
        fail_format(text, TimeFormat::iso);
    fail(Status::format, "{text} = \"%.60s\": is %s from UTC: must be a time of UTC, with Z or +00:00, or without both",
         text, offset.c_str());
}

void check_range(const char *text, int64_t day, Scale scale) {
    if (!in_range(day, scale))
        fail(Status::range, "{text} = \"%.60s\": must be from %s to 2099-12-31", text, first_date(scale));
}

} // namespace

int64_t last_day_of_utc() noexcept {
    return last_day;
}

const char *first_date(Scale scale) noexcept {
    return scale == Scale::utc ? "1972-01-01, when leap seconds began," : "1958-01-01";
}

int64_t parse_time(const char *text, TimeFormat format, Scale scale, const LeapSeconds &leap_seconds, int64_t offset) {
    const auto length_of = [&](int64_t day) {
        return (scale == Scale::utc ? leap_seconds.seconds_of(day) : 86400) * kSecond;
    };
    if (format == TimeFormat::iso) {
        const std::optional<DayTime> date = parse_date(text);
        if (!date)
            fail_date(text);
        if (date->has_zone && scale != Scale::utc)
            fail_format(text, format);
        check_range(text, date->day, scale);
        if (date->ns >= length_of(date->day))
            fail(Status::format, "{text} = \"%.60s\": that day has no such second", text);
        return tai_of(date->day, date->ns, scale, leap_seconds);
    }
    const std::optional<Days> parsed = Days::parse(text);
    if (!parsed)
        fail_format(text, format);
    const Days days = format == TimeFormat::jd ? parsed->plus_half() : *parsed;
    const int64_t whole = days.whole() < 0 ? -kEndDay * 1000 : std::min(days.whole(), INT64_MAX - offset);
    const int64_t day = whole + offset - (format == TimeFormat::jd ? kHalfDayOfJd : 0);
    check_range(text, day, scale);
    return tai_of(day, days.rest(length_of(day)), scale, leap_seconds);
}

std::optional<int64_t> to_tai(int64_t ns, Scale scale, const LeapSeconds &leap_seconds) noexcept {
    const int64_t days = ns / kDay - (ns % kDay < 0), day = days + kDayOf1970;
    if (!in_range(day, scale))
        return std::nullopt;
    return tai_of(day, ns - days * kDay, scale, leap_seconds);
}

} // namespace toliman::ingest
