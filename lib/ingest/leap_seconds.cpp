#include "ingest/leap_seconds.hpp"

#include <algorithm>
#include <string_view>

#include "base/error.hpp"
#include "ingest/text_lines.hpp"

namespace toliman::ingest {

namespace {

constexpr int64_t kFirstDay = 41317; // 1972-01-01
constexpr int32_t kFirstSeconds = 10;
constexpr int64_t kDay = 86400, kDayOf1900 = 15020;
constexpr size_t kLargestFile = 1 << 20;

// Removes the first word of the text; empty unless it is an integer.
std::optional<int64_t> take_integer(std::string_view &text) noexcept {
    const size_t end = std::min(text.find_first_of(" \t"), text.size());
    const std::optional<int64_t> value = integer_of(text.substr(0, end));
    text = TextLines::trimmed(text.substr(end));
    return value;
}

int64_t day_of(std::optional<int64_t> seconds, const TextLines &lines) {
    if (!seconds || *seconds < 0 || *seconds % kDay != 0)
        fail(Status::format, "{%s}:%d: must begin with the seconds from 1900-01-01 to the beginning of a day",
             lines.path(), lines.number());
    return *seconds / kDay + kDayOf1900;
}

erfa::LeapSecond row_of(std::string_view line, const TextLines &lines) {
    line = TextLines::trimmed(line.substr(0, line.find('#')));
    const int64_t day = day_of(take_integer(line), lines);
    const std::optional<int64_t> tai_utc = take_integer(line);
    if (!tai_utc || !line.empty() || *tai_utc < INT32_MIN || *tai_utc > INT32_MAX)
        fail(Status::format, "{%s}:%d: must be the seconds since 1900-01-01 and TAI - UTC, two integers", lines.path(),
             lines.number());
    return {day, static_cast<int32_t>(*tai_utc)};
}

} // namespace

bool may_follow(const LeapSecondRows &rows, const erfa::LeapSecond &next) noexcept {
    if (rows.empty())
        return next.day == kFirstDay && next.tai_utc == kFirstSeconds;
    const int64_t step = int64_t{next.tai_utc} - rows.back().tai_utc;
    return next.day > rows.back().day && (step == 1 || step == -1);
}

std::optional<int32_t> LeapSeconds::tai_utc(int64_t day) const noexcept {
    const auto later = [](int64_t wanted, const erfa::LeapSecond &row) { return wanted < row.day; };
    const auto after = std::upper_bound(rows_.begin(), rows_.end(), day, later);
    if (after == rows_.begin())
        return std::nullopt;
    return (after - 1)->tai_utc;
}

int64_t LeapSeconds::seconds_of(int64_t day) const noexcept {
    const std::optional<int32_t> today = tai_utc(day), tomorrow = tai_utc(day + 1);
    return kDay + (today && tomorrow ? *tomorrow - *today : 0);
}

erfa::LeapSecondTable read_leap_seconds(const std::string &path) {
    TextLines lines(path, kLargestFile);
    erfa::LeapSecondTable list = {{}, 0};
    for (std::string_view line; lines.next(line);) {
        if (line.substr(0, 2) == "#@") {
            line = TextLines::trimmed(line.substr(2));
            list.expires = day_of(take_integer(line), lines);
            continue;
        }
        if (line.empty() || line[0] == '#')
            continue;
        const erfa::LeapSecond row = row_of(line, lines);
        if (!may_follow(list.rows, row))
            fail(Status::format, "{%s}:%d: %s", lines.path(), lines.number(), kLeapSecondRule);
        list.rows.push_back(row);
    }
    if (list.rows.empty())
        fail(Status::format, "{%s}: contains no leap seconds: must be the leap-seconds.list of the IERS", path.c_str());
    if (list.expires <= list.rows.back().day)
        fail(Status::format, "{%s}: needs a line #@ with its expiry, after its last leap second", path.c_str());
    return list;
}

} // namespace toliman::ingest
