// Method: all arithmetic is on integers. A time in nanoseconds has 19 digits, a double holds 16, so a decimal number is
// read as a 128-bit integer and a power of ten. The power is kept as a divisor until the length of the day is known,
// because a day of UTC may have 86,401 s.
#include "ingest/time_text.hpp"

#include "backend/erfa.hpp"

namespace toliman::ingest {

namespace {

constexpr int kDigits = 24; // of a number; further ones are ignored
constexpr int kPlaces =
    23; // after the point: part_ and scale_, below 2e23, times the length of a day fit into 128 bits
constexpr int kMostExponent = 9999;
constexpr int64_t kSecond = 1000000000;

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

// Nanoseconds of ".5", "." or ""; empty for other texts.
std::optional<int64_t> fraction_of(std::string_view text) noexcept {
    int64_t ns = 0, unit = kSecond;
    for (size_t i = 0; i < text.size(); i++) {
        if (i == 0 ? text[i] != '.' : !is_digit(text[i]))
            return std::nullopt;
        if (i > 0) {
            unit /= 10;
            ns += unit * (text[i] - '0');
        }
    }
    return ns;
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
    if (!matches(text, "0000-00-00"))
        return std::nullopt;
    const auto day = erfa::day_of(digits_at(text, 0, 4), digits_at(text, 5, 2), digits_at(text, 8, 2));
    if (!day || text.size() == 10)
        return day ? std::optional<DayTime>({*day, 0}) : std::nullopt;
    if (!matches(text.substr(10), "T00:00:00"))
        return std::nullopt;
    const int hour = digits_at(text, 11, 2), minute = digits_at(text, 14, 2), second = digits_at(text, 17, 2);
    const std::optional<int64_t> fraction = fraction_of(text.substr(19));
    const bool last_minute = hour == 23 && minute == 59;
    if (!fraction || hour > 23 || minute > 59 || second > (last_minute ? 60 : 59))
        return std::nullopt;
    return DayTime{*day, ((hour * 60 + minute) * 60 + second) * kSecond + *fraction};
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
    sum.whole_ = whole_ + (2 * part_ + scale_ >= sum.scale_);
    return sum;
}

int64_t Days::rest(int64_t length) const noexcept {
    return static_cast<int64_t>((part_ * length + scale_ / 2) / scale_);
}

} // namespace toliman::ingest
