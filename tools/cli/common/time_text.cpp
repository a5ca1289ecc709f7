// Method: all arithmetic is on integers. A time in nanoseconds has 19 digits, a double holds 16, so a decimal
// number is read as a 128-bit integer and a power of ten, multiplied by the unit and divided with rounding. Calendar
// days are counted with years that begin in March, so that the leap day is the last day of a year.
#include "common/time_text.hpp"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace cli {

namespace {

__extension__ using Wide = __int128;

constexpr int kDigits = 24; // a number of so many digits times 86,401e9 fits into 128 bits
constexpr int64_t kSecond = 1000000000, kMjdOf1970 = 40587;

// Days since 1970-01-01 in the Gregorian calendar.
int64_t days_of(int64_t year, int64_t month, int64_t day) noexcept {
    const int64_t y = month > 2 ? year : year - 1, m = month > 2 ? month - 3 : month + 9;
    return 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 719469;
}

int64_t days_in(int64_t year, int64_t month) noexcept {
    return (month < 12 ? days_of(year, month + 1, 1) : days_of(year + 1, 1, 1)) - days_of(year, month, 1);
}

// Whether the text begins with the pattern, in which 0 stands for any digit.
bool matches(const std::string &text, const std::string &pattern) {
    if (text.size() < pattern.size())
        return false;
    for (size_t i = 0; i < pattern.size(); i++)
        if (pattern[i] == '0' ? std::isdigit(static_cast<unsigned char>(text[i])) == 0 : text[i] != pattern[i])
            return false;
    return true;
}

int64_t number(const std::string &text, size_t at, size_t size) {
    return std::atoll(text.substr(at, size).c_str());
}

// Reads digits with at most one point into an integer; `exponent` is decreased by the number of digits after the point.
bool read_digits(const std::string &text, size_t &at, Wide &value, int &exponent) {
    int digits = 0, counted = 0;
    bool point = false;
    for (; at < text.size(); at++) {
        if (text[at] == '.' && !point) {
            point = true;
            continue;
        }
        if (std::isdigit(static_cast<unsigned char>(text[at])) == 0)
            break;
        digits++;
        if (counted < kDigits) {
            value = 10 * value + (text[at] - '0');
            counted += value > 0;
            exponent -= point;
        } else {
            exponent += !point;
        }
    }
    return digits > 0;
}

bool read_exponent(const std::string &text, size_t &at, int &exponent) {
    if (at == text.size())
        return true;
    if (std::string("eEdD").find(text[at]) == std::string::npos)
        return false;
    int power = 0, length = 0;
    if (std::sscanf(text.c_str() + at + 1, "%4d%n", &power, &length) != 1 || text[at + 1] == ' ')
        return false;
    at += 1 + static_cast<size_t>(length);
    exponent += power;
    return at == text.size();
}

} // namespace

std::optional<int64_t> times_unit(const std::string &text, int64_t unit) {
    const bool negative = !text.empty() && text[0] == '-';
    size_t at = negative || (!text.empty() && text[0] == '+') ? 1 : 0;
    Wide value = 0;
    int exponent = 0;
    if (!read_digits(text, at, value, exponent) || !read_exponent(text, at, exponent))
        return std::nullopt;
    value *= unit;
    for (; exponent > 0 && value != 0; exponent--) {
        if (value > INT64_MAX)
            return std::nullopt;
        value *= 10;
    }
    Wide scale = 1;
    for (; exponent < 0 && scale <= value; exponent++) // for a larger scale the result rounds to 0
        scale *= 10;
    value = exponent < 0 ? 0 : (value + scale / 2) / scale;
    if (value > INT64_MAX)
        return std::nullopt;
    return static_cast<int64_t>(negative ? -value : value);
}

std::optional<int64_t> ns_of_days(double days) {
    constexpr double kMostDays = 100000; // 9.2e18 ns are 106751 days
    if (!(std::fabs(days) <= kMostDays))
        return std::nullopt;
    const double whole = std::floor(days);
    return static_cast<int64_t>(whole) * 86400 * kSecond + std::llround((days - whole) * 86400e9);
}

std::optional<DayTime> read_date(const std::string &text) {
    if (!matches(text, "0000-00-00"))
        return std::nullopt;
    const int64_t year = number(text, 0, 4), month = number(text, 5, 2), day = number(text, 8, 2);
    if (month < 1 || month > 12 || day < 1 || day > days_in(year, month))
        return std::nullopt;
    DayTime time = {kMjdOf1970 + days_of(year, month, day), 0};
    if (text.size() == 10)
        return time;
    if (!matches(text.substr(10), "T00:00:00") || (text.size() > 19 && text[19] != '.'))
        return std::nullopt;
    const std::string second = text.substr(17, 12); // truncated to nanoseconds, so that 59.9999999999 is not 60
    const int64_t hour = number(text, 11, 2), minute = number(text, 14, 2);
    const std::optional<int64_t> ns = times_unit(second, kSecond);
    if (hour > 23 || minute > 59 || !ns || text.find_first_not_of("0123456789", 20) != std::string::npos)
        return std::nullopt;
    if (second >= "61" || (second >= "60" && (hour != 23 || minute != 59)))
        return std::nullopt;
    time.ns = (hour * 60 + minute) * 60 * kSecond + *ns;
    return time;
}

} // namespace cli
