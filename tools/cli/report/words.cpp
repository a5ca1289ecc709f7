#include "report/words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <vector>

#include "common/text.hpp"

namespace cli {

namespace {

constexpr const char *kUnknown = "&ndash;";

std::string with_exponent(double mantissa, long exponent, int digits) {
    return printed("%.*f&nbsp;&times;&nbsp;10<sup>%s%ld</sup>", digits - 1, mantissa, exponent < 0 ? "&minus;" : "",
                   std::labs(exponent));
}

// Bytes of the character that starts there; 0 where that is no UTF-8.
size_t bytes_of_character(const std::string &text, size_t at) {
    const auto byte = [&](size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u; };
    const unsigned first = byte(0);
    if (first < 0x80)
        return 1;
    const size_t size = first >= 0xc2 && first < 0xe0   ? 2
                        : first >= 0xe0 && first < 0xf0 ? 3
                        : first >= 0xf0 && first < 0xf5 ? 4
                                                        : 0;
    for (size_t i = 1; i < size; i++)
        if (byte(i) >> 6 != 2)
            return 0;
    const bool too_long = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
    const bool no_character = (first == 0xed && byte(1) > 0x9f) || (first == 0xf4 && byte(1) > 0x8f);
    return too_long || no_character ? 0 : size;
}

// With U+FFFD in place of bytes that are no UTF-8, as names of files may have.
std::string readable(const std::string &text) {
    std::string clean;
    for (size_t at = 0; at < text.size();) {
        const size_t size = bytes_of_character(text, at);
        clean += size > 0 ? text.substr(at, size) : "\xef\xbf\xbd";
        at += std::max<size_t>(size, 1);
    }
    return clean;
}

} // namespace

std::string printed(const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int size = std::vsnprintf(nullptr, 0, format, arguments);
    va_end(arguments);
    std::string text(size > 0 ? static_cast<size_t>(size) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, again);
    va_end(again);
    return text;
}

std::string exponential(double value, int digits) {
    if (!std::isfinite(value))
        return kUnknown;
    if (value == 0)
        return "0";
    const int exponent = exponent_of(value, digits);
    const std::string mantissa = printed("%.*e", digits - 1, std::fabs(value));
    return (value < 0 ? "&minus;" : "") +
           with_exponent(std::stod(mantissa.substr(0, mantissa.find('e'))), exponent, digits);
}

std::string scientific(double value, int digits) {
    const int exponent = std::isfinite(value) ? exponent_of(value, digits) : digits;
    if (value == 0 || (exponent >= -3 && exponent < digits))
        return (value < 0 ? "&minus;" : "") + printed("%.*g", digits, std::fabs(value));
    return exponential(value, digits);
}

std::string with_error(double value, double error, int least_decimals) {
    const int decimals = decimals_of(error, least_decimals);
    return fixed(value, decimals) + " &plusmn; " + fixed(error, decimals);
}

std::string fixed(double value, int decimals) {
    if (!std::isfinite(value))
        return kUnknown;
    const std::string size = printed("%.*f", decimals, std::fabs(value));
    const bool is_zero = size.find_first_not_of("0.") == std::string::npos;
    return (value < 0 && !is_zero ? "&minus;" : "") + size;
}

ShortUnit short_unit(const std::vector<double> &numbers, const std::string &unit) {
    double most = 0;
    for (const double number : numbers)
        if (std::isfinite(number))
            most = std::max(most, std::fabs(number));
    const int exponent = most > 0 ? 3 * static_cast<int>(std::floor(std::log10(most) / 3)) : 0;
    return {std::pow(10, -exponent), exponent != 0 ? printed("10^{%d} ", exponent) + unit : unit};
}

std::string escaped(const std::string &text) {
    std::string safe;
    for (const char letter : readable(text))
        switch (letter) {
        case '&':
            safe += "&amp;";
            break;
        case '<':
            safe += "&lt;";
            break;
        case '>':
            safe += "&gt;";
            break;
        case '"':
            safe += "&quot;";
            break;
        case '\'':
            safe += "&#39;";
            break;
        default:
            safe += letter;
        }
    return safe;
}

std::string base64(const std::string &bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        unsigned three = 0;
        for (size_t k = 0; k < 3; k++)
            three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; k++)
            text += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string gnuplot_text(const std::string &text) {
    std::string safe = "'";
    for (const char letter : readable(text)) {
        if (letter == '\'')
            safe += '\'';
        safe += letter >= 0 && letter < ' ' ? ' ' : letter;
    }
    return safe + "'";
}

} // namespace cli
