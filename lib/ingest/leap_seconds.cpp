// Method: a list is believed where it agrees with itself and with ERFA. Its hash (#h) is the SHA-1 of its digits: the
// date of the list (#$), its expiry (#@), and both numbers of each row, without blanks. Official lists have #$ and end
// with #h, so that one without #h is truncated. ERFA knows every leap second before its release, and those of its
// table: up to there both must have the same rows; later rows are news. Reference: the comments in leap-seconds.list,
// IERS.
#include "ingest/leap_seconds.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "base/error.hpp"
#include "base/sha1.hpp"
#include "ingest/text_lines.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr int32_t kFirstSeconds = 10;
constexpr int64_t kSecondsPerDay = kDay / kSecond, kDayOf1900 = 15020;
constexpr size_t kLargestList = 1 << 20;

// Removes the first word of the text; empty unless it is an integer.
std::optional<int64_t> take_integer(std::string_view &text) noexcept {
    const size_t end = std::min(text.find_first_of(" \t"), text.size());
    const std::optional<int64_t> value = integer_of(text.substr(0, end));
    text = TextLines::trimmed(text.substr(end));
    return value;
}

int64_t day_of(std::optional<int64_t> seconds, const TextLines &lines) {
    if (!seconds || *seconds < 0 || *seconds % kSecondsPerDay != 0)
        fail(Status::format, "{%s}:%d: must begin with the seconds from 1900-01-01 to the beginning of a day",
             lines.path(), lines.number());
    return *seconds / kSecondsPerDay + kDayOf1900;
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

// Five words of hexadecimal digits, whose leading zeros some lists omit.
std::array<uint32_t, 5> hash_of(std::string_view text, const TextLines &lines) {
    std::array<uint32_t, 5> hash = {};
    for (uint32_t &word : hash) {
        const size_t size = std::min(text.find_first_of(" \t"), text.size());
        const auto [end, error] = std::from_chars(text.data(), text.data() + size, word, 16);
        if (error != std::errc() || end != text.data() + size)
            fail(Status::format, "{%s}:%d: must be #h and the five words of a SHA-1, hexadecimal", lines.path(),
                 lines.number());
        text = TextLines::trimmed(text.substr(size));
    }
    if (!text.empty())
        fail(Status::format, "{%s}:%d: has more than the five words of a SHA-1", lines.path(), lines.number());
    return hash;
}

// What a list says about itself.
struct Seal {
    std::string date, expiry, rows; // digits
    std::optional<std::array<uint32_t, 5>> hash;
    bool has_date = false;
};

std::string digits_of(std::string_view text) {
    std::string digits;
    for (const char c : text.substr(0, text.find('#')))
        if (c != ' ' && c != '\t')
            digits += c;
    return digits;
}

void check_hash(const std::string &path, const Seal &seal) {
    if (seal.has_date && !seal.hash)
        fail(Status::format, "{%s}: has a date (#$), but no hash (#h): it is truncated", path.c_str());
    if (seal.hash && *seal.hash != sha1(seal.date + seal.expiry + seal.rows))
        fail(Status::format,
             "{%s}: its hash (#h) is not that of its rows, date and expiry: it is damaged, or was edited",
             path.c_str());
}

// Compares TAI - UTC on every day on which it changes in one of the two tables.
void check_against_erfa(const std::string &path, const LeapSecondRows &rows) {
    const erfa::LeapSecondTable &known = erfa::leap_seconds();
    const LeapSeconds listed(rows), built_in(known.rows);
    const int64_t end = std::max(known.complete, known.rows.back().day + 1);
    LeapSecondRows all = known.rows;
    all.insert(all.end(), rows.begin(), rows.end());
    std::sort(all.begin(), all.end(), [](const auto &a, const auto &b) { return a.day < b.day; });
    for (const erfa::LeapSecond &row : all)
        if (row.day < end && listed.tai_utc(row.day) != built_in.tai_utc(row.day))
            fail(Status::format,
                 "{%s}: TAI - UTC is %d s on MJD %lld: must be %d s as in the library's own table, whose last leap "
                 "second "
                 "is on MJD %lld: the list is old, truncated or damaged",
                 path.c_str(), listed.tai_utc(row.day).value_or(0), static_cast<long long>(row.day),
                 built_in.tai_utc(row.day).value_or(0), static_cast<long long>(known.rows.back().day));
}

} // namespace

bool may_follow(const LeapSecondRows &rows, const erfa::LeapSecond &next) noexcept {
    if (rows.empty())
        return next.day == kFirstDayOfUtc && next.tai_utc == kFirstSeconds;
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
    return kSecondsPerDay + (today && tomorrow ? *tomorrow - *today : 0);
}

erfa::LeapSecondTable read_leap_seconds(const std::string &path) {
    TextLines lines(path, kLargestList);
    erfa::LeapSecondTable list = {{}, 0, 0};
    Seal seal;
    for (std::string_view line; lines.next(line);) {
        const std::string_view mark = line.substr(0, std::min(line.find_first_of(" \t"), line.size()));
        const std::string_view rest = TextLines::trimmed(line.substr(mark.size()));
        if (mark == "#@") {
            seal.expiry = digits_of(rest);
            line = rest;
            list.expires = day_of(take_integer(line), lines);
        }
        if (mark == "#$") {
            seal.date = digits_of(rest);
            seal.has_date = true;
        }
        if (mark == "#h")
            seal.hash = hash_of(rest, lines);
        if (line.empty() || line[0] == '#')
            continue;
        const erfa::LeapSecond row = row_of(line, lines);
        if (!may_follow(list.rows, row))
            fail(Status::format, "{%s}:%d: %s", lines.path(), lines.number(), kLeapSecondRule);
        list.rows.push_back(row);
        seal.rows += digits_of(line);
    }
    if (list.rows.empty())
        fail(Status::format, "{%s}: contains no leap seconds: must be the leap-seconds.list of the IERS", path.c_str());
    if (list.expires <= list.rows.back().day)
        fail(Status::format, "{%s}: needs a line #@ with its expiry, after its last leap second", path.c_str());
    check_hash(path, seal);
    check_against_erfa(path, list.rows);
    return list;
}

} // namespace toliman::ingest
