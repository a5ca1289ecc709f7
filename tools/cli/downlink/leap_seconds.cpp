#include "downlink/leap_seconds.hpp"

#include <algorithm>
#include <cstdio>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/lines.hpp"

namespace cli {

namespace {

constexpr const char kBuiltIn[] =
#include "leap_seconds_table.inc"
    ;
constexpr int64_t kFirstDay = 41317, kFirstAhead = 10; // 1972-01-01
constexpr int64_t kDay = 86400, kDayOf1900 = 15020;

int64_t day_of(long long seconds, const LinePlace &where) {
    if (seconds < 0 || seconds % kDay != 0)
        malformed(where.text(), std::to_string(seconds) + ": must be the seconds from 1900 to the beginning of a day");
    return seconds / kDay + kDayOf1900;
}

} // namespace

LeapSeconds::LeapSeconds(const std::string &path) {
    const std::string text = path.empty() ? kBuiltIn : whole_text(path);
    int number = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        add(text.substr(at, end - at), {path, ++number});
        at = end + 1;
    }
    if (steps_.empty())
        malformed(path, "holds no leap seconds: must be the leap-seconds.list of the IERS");
    if (expires_ <= steps_.back().day)
        malformed(path, "has no line #@ of its expiry, which must lie after its last leap second");
}

void LeapSeconds::add(const std::string &line, const LinePlace &where) {
    long long seconds = 0, ahead = 0;
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos)
        return;
    if (std::sscanf(line.c_str(), "#@ %lld", &seconds) == 1)
        expires_ = day_of(seconds, where);
    if (line[first] == '#')
        return;
    if (std::sscanf(line.c_str(), "%lld %lld", &seconds, &ahead) != 2)
        malformed(where.text(), "must be seconds since 1900 and TAI - UTC, two whole numbers");
    const int64_t day = day_of(seconds, where);
    if (steps_.empty() && (day != kFirstDay || ahead != kFirstAhead))
        malformed(where.text(), "the table must begin on 1972-01-01 with 10 s");
    if (!steps_.empty() &&
        (day <= steps_.back().day || (ahead != steps_.back().ahead + 1 && ahead != steps_.back().ahead - 1)))
        malformed(where.text(), "must come after the line before and differ by a second");
    steps_.push_back({day, ahead});
}

std::optional<int64_t> LeapSeconds::ahead(int64_t day) const {
    const auto later = [](int64_t wanted, const Step &step) { return wanted < step.day; };
    const auto after = std::upper_bound(steps_.begin(), steps_.end(), day, later);
    if (after == steps_.begin())
        return std::nullopt;
    return (after - 1)->ahead;
}

int64_t LeapSeconds::seconds_of(int64_t day) const {
    const std::optional<int64_t> today = ahead(day), tomorrow = ahead(day + 1);
    return kDay + (today && tomorrow ? *tomorrow - *today : 0);
}

} // namespace cli
