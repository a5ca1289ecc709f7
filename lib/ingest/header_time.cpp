// Method: every keyword of a time is read, and becomes a statement about the start (MJD-BEG, DATE-BEG, MJD-OBS,
// DATE-OBS), the middle (MJD-AVG, DATE-AVG) or the end (MJD-END, DATE-END) of the exposure. The length is TELAPSE, from
// start to end; otherwise XPOSURE, EXPTIME or EXPOSURE; otherwise from the start to the end. One statement gives the
// time: the first of middle, start and end, of two keywords of one place the one with finer digits. All others must
// agree with it within half an exposure and their own last digit; otherwise the header is refused, as nobody knows
// which of them is right. TELAPSE may exceed the other lengths, which do not count pauses. A date without time states
// only its day. TIMESYS gives the scale, UTC by default; TDB is treated as TT, as everywhere. Reference: FITS Standard
// 4.0, section 9 (Time coordinates), and tables 30 (scales), 35 (times) and 36 (durations).
#include "ingest/header_time.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/side_line.hpp"
#include "ingest/time_scale.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr int64_t kRounding = kSecond / 1000; // of numbers that passed through a double

struct NamedScale {
    const char *name;
    Scale scale;
};
constexpr NamedScale kNamedScales[] = {{"UTC", Scale::utc}, {"TAI", Scale::tai}, {"IAT", Scale::tai},
                                       {"TT", Scale::tt},   {"TDT", Scale::tt},  {"ET", Scale::tt},
                                       {"TDB", Scale::tdb}, {"GPS", Scale::gps}, {"GMT", Scale::utc}};

enum class Part { middle, start, end };
struct Suffix {
    const char *name;
    Part part;
};
constexpr Suffix kSuffixes[] = {{"AVG", Part::middle}, {"BEG", Part::start}, {"OBS", Part::start}, {"END", Part::end}};
constexpr const char *kLengths[] = {"TELAPSE", "XPOSURE", "EXPTIME", "EXPOSURE"};
constexpr const char *kClocksOfUtc[] = {"UTC-OBS", "UT"}; // as TIME-OBS

// What a keyword states: the exposure starts, ends or has its middle between first_ns and last_ns, a day apart for a
// date without time.
struct Statement {
    std::string key; // "DATE-OBS + TIME-OBS"
    Part part;
    int64_t first_ns, last_ns, resolution_ns;
    bool is_day() const noexcept { return last_ns > first_ns; }
};

struct Length {
    std::string key;
    int64_t ns;
};

// A string of a header without its quotes.
std::string unquoted(const std::string &value) {
    if (value.size() < 2 || value.front() != '\'' || value.back() != '\'')
        return value;
    const std::string text = value.substr(1, value.size() - 2);
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
    return text;
}

// The name may be followed by a realisation in brackets, "UTC(NIST)".
const NamedScale &scale_of(const char *value) {
    if (value == nullptr)
        return kNamedScales[0];
    const std::string name = upper(unquoted(value));
    const size_t bracket = name.find('(');
    const bool is_closed = bracket == std::string::npos || name.find(')') == name.size() - 1;
    for (const NamedScale &scale : kNamedScales)
        if (is_closed && name.substr(0, bracket) == scale.name)
            return scale;
    fail(Status::format,
         "{TIMESYS} = %.70s: must be UTC, TAI, TT, TDT, ET, IAT, TDB, GPS or GMT, perhaps with a realisation in "
         "brackets",
         value);
}

// Times that light would have at other places, and lengths in other units than seconds.
void check_references(const Keywords &value_of) {
    const char *const place = value_of("TREFPOS"), *const unit = value_of("TIMEUNIT");
    const std::string where = place != nullptr ? upper(unquoted(place)) : "";
    for (const char *far : {"BARY", "HELIO", "EMBARY", "GALACT"})
        if (where.rfind(far, 0) == 0)
            fail(Status::format,
                 "{TREFPOS} = %.70s: must be TOPOCENTER or GEOCENTER: light arrives at others up to 500 s "
                 "earlier or later",
                 place);
    if (unit != nullptr && unquoted(unit) != "s" && (value_of("XPOSURE") != nullptr || value_of("TELAPSE") != nullptr))
        fail(Status::format, "{TIMEUNIT} = %.70s: must be 's' with XPOSURE and TELAPSE", unit);
}

int64_t time_of(const std::string &key, const std::string &text, TimeFormat format, Scale scale,
                const LeapSeconds &leap_seconds) {
    try {
        return parse_time(text.c_str(), format, scale, leap_seconds);
    } catch (const Error &error) {
        fail(error.status(), "{%s}: %s", key.c_str(), error.what());
    }
}

// Reads all keywords of times.
class TimeReader {
  public:
    TimeReader(const Keywords &value_of, Scale scale, const LeapSeconds &leap_seconds)
        : value_of_(value_of), scale_(scale), leap_seconds_(leap_seconds) {}

    std::vector<Statement> read() {
        for (const Suffix &suffix : kSuffixes) {
            read_day(suffix);
            read_date(suffix);
        }
        return std::move(statements_);
    }

  private:
    void read_day(const Suffix &suffix) {
        const std::string key = std::string("MJD-") + suffix.name;
        const char *const value = value_of_(key.c_str());
        if (value == nullptr)
            return;
        const int64_t tai_ns = time_of(key, value, TimeFormat::mjd, scale_, leap_seconds_);
        statements_.push_back({key, suffix.part, tai_ns, tai_ns, days_resolution(value)});
    }

    void read_date(const Suffix &suffix) {
        const std::string key = std::string("DATE-") + suffix.name;
        const char *const value = value_of_(key.c_str());
        if (value == nullptr)
            return;
        const std::string date = unquoted(value);
        const int64_t tai_ns = time_of(key, date, TimeFormat::iso, scale_, leap_seconds_);
        const bool is_bare = is_bare_date(date);
        if (!is_bare)
            statements_.push_back({key, suffix.part, tai_ns, tai_ns, date_resolution(date)});
        if (!read_clocks(key, date, suffix) && is_bare)
            statements_.push_back({key, suffix.part, tai_ns, tai_ns + kDay, kSecond});
    }

    // The time of day in a keyword of its own, with the day of a date.
    bool read_clocks(const std::string &key, const std::string &date, const Suffix &suffix) {
        bool found = read_clock(key, date, suffix, std::string("TIME-") + suffix.name);
        if (std::string_view(suffix.name) == "OBS")
            for (const char *clock : kClocksOfUtc)
                found = read_clock(key, date, suffix, clock) || found;
        return found;
    }

    bool read_clock(const std::string &key, const std::string &date, const Suffix &suffix, const std::string &clock) {
        const char *const value = value_of_(clock.c_str());
        if (value == nullptr)
            return false;
        if (clock[0] == 'U' && scale_ != Scale::utc)
            fail(Status::format, "{%s} = %.70s: contradicts TIMESYS, which is not UTC", clock.c_str(), value);
        const std::string text = unquoted(value), day = date.substr(0, date.find_first_of("T "));
        // Others write an hour below ten with one digit, or the same date again.
        const std::string hour = text.find(':') == 1 ? "0" : "";
        const std::string whole =
            text.size() > day.size() && text.compare(0, day.size(), day) == 0 ? text : day + "T" + hour + text;
        const std::optional<DayTime> parsed = parse_date(whole);
        if (!parsed || (parsed->has_zone && scale_ != Scale::utc))
            fail(Status::format, "{%s} = %.70s: must be hh:mm:ss[.s...], perhaps after the date of %s", clock.c_str(),
                 value, key.c_str());
        const int64_t tai_ns = time_of(clock, whole, TimeFormat::iso, scale_, leap_seconds_);
        statements_.push_back({key + " + " + clock, suffix.part, tai_ns, tai_ns, date_resolution(text)});
        return true;
    }

    const Keywords &value_of_;
    Scale scale_;
    const LeapSeconds &leap_seconds_;
    std::vector<Statement> statements_;
};

// In the order of kLengths. Days parses any decimal number without rounding.
std::vector<Length> lengths_of(const Keywords &value_of) {
    std::vector<Length> lengths;
    for (const char *key : kLengths) {
        const char *const value = value_of(key);
        if (value == nullptr)
            continue;
        const std::optional<Days> seconds = Days::parse(value);
        const bool is_known = seconds && seconds->whole() >= 0 && seconds->whole() <= kLongestExposure;
        const int64_t ns = is_known ? seconds->whole() * kSecond + seconds->rest(kSecond) : -1;
        if (ns < 0 || ns > kLongestExposure * kSecond)
            fail(Status::format, "{%s} = %.70s: must be from 0 to 1e9 s", key, value);
        lengths.push_back({key, ns});
    }
    return lengths;
}

std::string seconds_text(int64_t ns) {
    char text[40];
    print_text(text, sizeof text, "%.9g s", static_cast<double>(ns) / static_cast<double>(kSecond));
    return text;
}

[[noreturn]] void fail_contradiction(const std::string &key, const std::string &other, const std::string &how) {
    fail(Status::format, "{%s} contradicts %s: %s", key.c_str(), other.c_str(), how.c_str());
}

// The statement of a part that has the finest digits, the first of equal ones; nullptr for none with a time.
const Statement *finest(const std::vector<Statement> &statements, Part part) {
    const Statement *found = nullptr;
    for (const Statement &each : statements)
        if (each.part == part && !each.is_day() && (found == nullptr || each.resolution_ns < found->resolution_ns))
            found = &each;
    return found;
}

// The length from start to end. Without any keyword of a length, from the statements; nothing if these are too few.
std::optional<Length> length_of(const std::vector<Statement> &statements, const std::vector<Length> &lengths) {
    const Statement *const start = finest(statements, Part::start), *const end = finest(statements, Part::end);
    if (lengths.empty()) {
        if (start == nullptr || end == nullptr)
            return std::nullopt;
        const int64_t ns = end->first_ns - start->first_ns;
        if (ns < 0)
            fail_contradiction(start->key, end->key,
                               "the exposure would end " + seconds_text(-ns) + " before it starts");
        if (ns > kLongestExposure * kSecond)
            fail_contradiction(start->key, end->key, "the exposure would take more than 1e9 s");
        return Length{end->key + " - " + start->key, ns};
    }
    const Length &chosen = lengths.front();
    const bool has_pauses = chosen.key == kLengths[0];
    for (const Length &other : lengths) {
        const int64_t excess = other.ns - chosen.ns, limit = std::min(chosen.ns, other.ns) / 2 + kRounding;
        if (excess > limit || (-excess > limit && !has_pauses))
            fail_contradiction(chosen.key, other.key,
                               seconds_text(chosen.ns) + " and " + seconds_text(other.ns) + " for the same exposure");
    }
    return chosen;
}

// Where the middle is, relative to a statement about a part.
int64_t to_middle(Part part, int64_t length) noexcept {
    return part == Part::middle ? 0 : part == Part::start ? length / 2 : -(length / 2);
}

// Every statement must agree with the chosen one. Without a length those of other parts must only be in order.
void check_agreement(const std::vector<Statement> &statements, const Statement &chosen,
                     const std::optional<Length> &length) {
    static constexpr int kOrder[] = {1, 0, 2}; // of Part
    const auto order = [](const Statement &of) { return kOrder[static_cast<size_t>(of.part)]; };
    const int64_t ns = length ? length->ns : 0;
    const int64_t middle = chosen.first_ns + to_middle(chosen.part, ns);
    for (const Statement &other : statements) {
        const int64_t shift = to_middle(other.part, ns);
        const int64_t limit = (length ? ns / 2 : kSecond) + kRounding + chosen.resolution_ns + other.resolution_ns;
        const int64_t late = other.first_ns + shift - middle, early = middle - (other.last_ns + shift);
        const bool may_be_later = !length && order(other) > order(chosen);
        const bool may_be_earlier = !length && order(other) < order(chosen);
        const int64_t gap = late > limit && !may_be_later ? late : early > limit && !may_be_earlier ? early : 0;
        if (gap > 0)
            fail_contradiction(chosen.key, other.key,
                               seconds_text(gap) + " apart" +
                                   (length ? ", with " + length->key + " = " + seconds_text(ns) : ""));
    }
}

const Statement &chosen_of(const std::vector<Statement> &statements) {
    for (const Part part : {Part::middle, Part::start, Part::end})
        if (const Statement *const found = finest(statements, part))
            return *found;
    if (statements.empty())
        fail(Status::not_found,
             "{header} has no time: none of MJD-AVG, DATE-AVG, MJD-BEG, DATE-BEG, MJD-OBS, DATE-OBS, "
             "MJD-END and DATE-END");
    fail(Status::format, "{%s} is a date without a time: must be YYYY-MM-DDThh:mm:ss, or have TIME-%s",
         statements[0].key.c_str(), statements[0].key.substr(statements[0].key.size() - 3).c_str());
}

std::string rule_of(const Statement &chosen, const std::optional<Length> &length) {
    if (chosen.part == Part::middle)
        return chosen.key;
    if (!length)
        return chosen.key + ", taken as mid-exposure as its length is missing,";
    const bool is_keyword = length->key.find(' ') == std::string::npos;
    if (!is_keyword)
        return "the middle of " + chosen.key + " and " + length->key.substr(0, length->key.rfind(" - "));
    return chosen.key + (chosen.part == Part::start ? " + " : " - ") + length->key + "/2";
}

} // namespace

HeaderTime header_time(const Keywords &value_of, const LeapSeconds &leap_seconds, int64_t expires) {
    const char *const timesys = value_of("TIMESYS");
    const NamedScale &scale = scale_of(timesys);
    const std::vector<Statement> statements = TimeReader(value_of, scale.scale, leap_seconds).read();
    const Statement &chosen = chosen_of(statements);
    check_references(value_of);
    const std::optional<Length> length = length_of(statements, lengths_of(value_of));
    check_agreement(statements, chosen, length);
    const int64_t utc_ns = chosen.first_ns - leap_seconds.tai_utc(expires).value_or(0) * kSecond;
    const int64_t length_ns = length ? length->ns : 0;
    return {chosen.first_ns + to_middle(chosen.part, length_ns), length_ns,
            timesys == nullptr || (!length && chosen.part != Part::middle),
            scale.scale == Scale::utc && utc_ns / kDay + kDayOf1970 >= expires,
            rule_of(chosen, length) + " in " + scale.name + (timesys == nullptr ? ", as TIMESYS is missing" : "")};
}

} // namespace toliman::ingest
