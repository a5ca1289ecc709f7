// Method: all arithmetic is on integers. A day of the year is counted from 1 January. A time in nanoseconds has 19
// digits, a double holds 16, so a decimal number is read as a 128-bit integer and a power of ten. The power is kept as
// a divisor until the length of the day is known, because a day of UTC may have 86,401 s. Reference: ISO 8601; CCSDS
// 301.0-B, ASCII time codes A and B.
#include "ingest/time_text.hpp"

#include <algorithm>
#include <iterator>

#include "backend/erfa.hpp"

namespace toliman::ingest {

namespace {

constexpr int kDigits = 24; // of a number; further ones are ignored
constexpr int kPlaces =
    23; // after the point: part_ and scale_, below 2e23, times the length of a day fit into 128 bits
constexpr int kMostExponent = 9999;

bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}

// Whether the text begins with the pattern, in which 0 is any digit.
bool matches(std::string_view text, std::string_view pattern) noexcept {
    if (text.size() < pattern.size())
        return false;
    for (size_t i = 0; i < pattern.size(); i++)
        if (pattern[i] == '0' ? !is_digit(text[i]) : text[i] != pattern[i])
            return false;
    return true;
}

int digits_at(std::string_view text, size_t at, size_t size) noexcept {
    int value = 0;
    for (const char c : text.substr(at, size))
        value = 10 * value + (c - '0');
    return value;
}

constexpr size_t kClock = 8, kOrdinal = 8, kCalendar = 10; // lengths of hh:mm:ss, YYYY-DDD and YYYY-MM-DD
constexpr std::string_view kDigitSet = "0123456789";

// The length of the date at the beginning; 0 for none.
size_t date_length(std::string_view text) noexcept {
    if (matches(text, "0000-00-00"))
        return kCalendar;
    return matches(text, "0000-000") && !(text.size() > kOrdinal && is_digit(text[kOrdinal])) ? kOrdinal : 0;
}

// The day of a text of that length. The day of the year is counted from 1 January.
std::optional<int64_t> day_of(std::string_view date) noexcept {
    const int year = digits_at(date, 0, 4);
    if (date.size() == kCalendar)
        return erfa::day_of(year, digits_at(date, 5, 2), digits_at(date, 8, 2));
    const auto first = erfa::day_of(year, 1, 1), last = erfa::day_of(year, 12, 31);
    const int day = digits_at(date, 5, 3);
    if (!first || day < 1 || *first + day - 1 > *last)
        return std::nullopt;
    return *first + day - 1;
}

// Removes ".5", "." or nothing from the beginning; nanoseconds.
int64_t take_fraction(std::string_view &text) noexcept {
    int64_t ns = 0, unit = kSecond;
    if (text.empty() || text[0] != '.')
        return 0;
    text.remove_prefix(1);
    for (; !text.empty() && is_digit(text[0]); text.remove_prefix(1)) {
        unit /= 10;
        ns += unit * (text[0] - '0');
    }
    return ns;
}

bool is_utc(std::string_view zone) noexcept {
    constexpr std::string_view kZones[] = {"Z", "+00:00", "-00:00", "+0000", "-0000", "+00", "-00"};
    return std::find(std::begin(kZones), std::end(kZones), zone) != std::end(kZones);
}

int64_t power_of_ten(int exponent) noexcept {
    int64_t power = 1;
    for (; exponent > 0; exponent--)
        power *= 10;
    return power;
}

// Removes a leading + or -; true for -.
bool take_sign(std::string_view &text) noexcept {
    const bool negative = !text.empty() && text[0] == '-';
    if (negative || (!text.empty() && text[0] == '+'))
        text.remove_prefix(1);
    return negative;
}

// e-5, D+2 or nothing; empty for other texts. Large exponents are cut to +-9999.
std::optional<int> exponent_of(std::string_view text) noexcept {
    if (text.empty())
        return 0;
    if (std::string_view("eEdD").find(text[0]) == std::string_view::npos)
        return std::nullopt;
    text.remove_prefix(1);
    const bool negative = take_sign(text);
    int value = 0;
    for (const char c : text) {
        if (!is_digit(c))
            return std::nullopt;
        value = value < kMostExponent ? 10 * value + (c - '0') : value;
    }
    value = value < kMostExponent ? value : kMostExponent;
    return text.empty() ? std::nullopt : std::optional<int>(negative ? -value : value);
}

} // namespace

std::optional<DayTime> parse_date(std::string_view text) noexcept {
    const size_t length = date_length(text);
    const auto day = length > 0 ? day_of(text.substr(0, length)) : std::nullopt;
    if (!day || text.size() == length)
        return day ? std::optional<DayTime>({*day, 0, false, false}) : std::nullopt;
    std::string_view time = text.substr(length + 1);
    if ((text[length] != 'T' && text[length] != ' ') || !matches(time, "00:00:00"))
        return std::nullopt;
    const int hour = digits_at(time, 0, 2), minute = digits_at(time, 3, 2), second = digits_at(time, 6, 2);
    time.remove_prefix(kClock);
    const int64_t fraction = take_fraction(time);
    const bool last_minute = hour == 23 && minute == 59;
    if (hour > 23 || minute > 59 || second > (last_minute ? 60 : 59) || !(time.empty() || is_utc(time)))
        return std::nullopt;
    return DayTime{*day, ((hour * 60 + minute) * 60 + second) * kSecond + fraction, true, !time.empty()};
}

std::string_view offset_of(std::string_view text) noexcept {
    const size_t sign = text.find_last_of("+-");
    if (sign == std::string_view::npos || sign < kOrdinal + kClock || !matches(text.substr(sign + 1), "00"))
        return {};
    return text.substr(sign);
}

bool is_bare_date(std::string_view text) noexcept {
    const auto date = parse_date(text);
    return date && !date->has_time;
}

bool begins_with_date(std::string_view text) noexcept {
    return date_length(text) > 0;
}

size_t first_field(std::string_view text) noexcept {
    constexpr const char *kBlanks = " \t\r\v\f";
    const size_t end = std::min(text.find_first_of(kBlanks), text.size());
    const bool continues =
        end > 0 && end == date_length(text) && text.substr(end, 1) == " " && matches(text.substr(end + 1), "00:00:00");
    return continues ? std::min(text.find_first_of(kBlanks, end + 1), text.size()) : end;
}

int64_t date_resolution(std::string_view text) noexcept {
    if (text.find(':') == std::string_view::npos)
        return kDay;
    const size_t point = text.find('.');
    if (point == std::string_view::npos)
        return kSecond;
    const size_t end = std::min(text.find_first_not_of(kDigitSet, point + 1), text.size());
    return kSecond / power_of_ten(static_cast<int>(std::min<size_t>(end - point - 1, 9)));
}

int64_t days_resolution(std::string_view text) noexcept {
    constexpr int kFewest = 4, kMost = 14; // digits of a day in ns
    const size_t mark = std::min(text.find_first_of("eEdD"), text.size());
    const size_t point = std::min(text.find('.'), mark);
    const int digits = static_cast<int>(std::min<size_t>(mark - std::min(point + 1, mark), kMostExponent));
    const int places = digits - exponent_of(text.substr(mark)).value_or(0);
    return places < kFewest ? kSecond : std::max<int64_t>(1, kDay / power_of_ten(std::min(places, kMost)));
}

std::optional<Days> Days::parse(std::string_view text) noexcept {
    const bool negative = take_sign(text);
    Wide value = 0;
    int digits = 0, counted = 0, exponent = 0;
    bool point = false;
    size_t at = 0;
    for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && !point)); at++) {
        if (text[at] == '.') {
            point = true;
            continue;
        }
        digits++;
        if (counted < kDigits) {
            value = 10 * value + (text[at] - '0');
            counted += value > 0;
            exponent -= point;
        } else {
            exponent += !point;
        }
    }
    const std::optional<int> power = exponent_of(text.substr(at));
    if (digits == 0 || !power)
        return std::nullopt;
    return Days(negative ? -value : value, exponent + *power);
}

Days::Days(Wide value, int exponent) noexcept {
    if (value < 0) {
        whole_ = -1;
        return;
    }
    for (; exponent > 0 && value != 0 && value <= INT64_MAX; exponent--)
        value *= 10;
    for (; exponent < -kPlaces && value != 0; exponent++)
        value /= 10;
    for (; exponent < 0 && value != 0; exponent++)
        scale_ *= 10;
    const Wide whole = value / scale_;
    whole_ = whole > INT64_MAX ? INT64_MAX : static_cast<int64_t>(whole);
    part_ = value % scale_;
}

Days Days::plus_half() const noexcept {
    Days sum;
    sum.scale_ = 2 * scale_;
    sum.part_ = (2 * part_ + scale_) % sum.scale_;
    sum.whole_ = whole_ + (whole_ < INT64_MAX && 2 * part_ + scale_ >= sum.scale_);
    return sum;
}

int64_t Days::rest(int64_t length) const noexcept {
    return static_cast<int64_t>((part_ * length + scale_ / 2) / scale_);
}

} // namespace toliman::ingest
