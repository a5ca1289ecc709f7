// Method: a field must be one number to its last character, so that a damaged number is an error and never a shorter
// one. std::from_chars reads it, whose decimal point does not depend on the locale.
#include "ingest/fields.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kNone = std::string_view::npos;

bool is_space(char c) noexcept {
    return c == ' ' || (c >= '\t' && c <= '\r' && c != '\n');
}

// Without surrounding white space.
std::string_view inner(std::string_view text) noexcept {
    while (!text.empty() && is_space(text.front()))
        text.remove_prefix(1);
    while (!text.empty() && is_space(text.back()))
        text.remove_suffix(1);
    return text;
}

// The end of the quoted text at the beginning, behind its last quote; kNone if it does not begin with one. Two quotes
// within are one.
size_t quote_end(std::string_view text) noexcept {
    if (text.empty() || text[0] != '"')
        return kNone;
    for (size_t at = text.find('"', 1); at != kNone; at = text.find('"', at + 2))
        if (text.substr(at + 1, 1) != "\"")
            return at + 1;
    return kNone;
}

// The length of the first field.
size_t field_length(std::string_view text, char separator) noexcept {
    size_t start = 0;
    while (start < text.size() && text[start] == ' ')
        start++;
    const size_t quoted = quote_end(text.substr(start));
    if (quoted != kNone) {
        const size_t next = text.find_first_not_of(" \r", start + quoted);
        if (next == kNone || text[next] == separator)
            return std::min(next, text.size());
    }
    return std::min(text.find(separator), text.size());
}

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (size_t start = line.find_first_not_of(kSpace); start != kNone;) {
        const std::string_view rest = line.substr(start);
        const size_t quoted = quote_end(rest), length = quoted != kNone ? quoted : first_field(rest);
        words.push_back(trimmed(rest.substr(0, length)));
        start = line.find_first_not_of(kSpace, start + length);
    }
    return words.empty() ? std::vector<std::string>{""} : words;
}

// The fields between bars, of which the first and the last are the borders.
std::string_view without_borders(std::string_view line) noexcept {
    const size_t first = line.find_first_not_of(kSpace), last = line.find_last_not_of(kSpace);
    if (first == kNone)
        return line;
    line = line.substr(0, last + 1);
    line.remove_suffix(line.back() == '|' && last > first);
    line.remove_prefix(line[first] == '|' ? first + 1 : 0);
    return line;
}

// Replaces what is within quotes and brackets by letters; brackets without an end remain.
std::string masked(std::string_view line) {
    std::string text(line);
    for (size_t at = 0; at < text.size(); at++) {
        const char *const open = std::strchr("\"([{", text[at]);
        if (text[at] == '\0' || open == nullptr)
            continue;
        const size_t end = text.find("\")]}"[*open == '"' ? 0 : *open == '(' ? 1 : *open == '[' ? 2 : 3], at + 1);
        if (end == kNone)
            continue;
        std::fill(text.begin() + static_cast<int64_t>(at), text.begin() + static_cast<int64_t>(end) + 1, 'x');
        at = end;
    }
    return text;
}

// Whether a number, without sign and prefix and far from 1, is above it: the place of its first digit other than 0,
// before or after the point, plus its exponent.
bool is_above_one(const char *at, const char *end, bool hex) noexcept {
    const char *const mark =
        std::find_if(at, end, [&](char c) { return hex ? c == 'p' || c == 'P' : c == 'e' || c == 'E'; });
    const char *const point = std::find(at, mark, '.');
    const char *const first = std::find_if(at, mark, [](char c) { return c != '0' && c != '.'; });
    int64_t exponent = 0;
    if (mark != end) {
        const char *const digits = mark + (mark[1] == '+' ? 2 : 1);
        if (std::from_chars(digits, end, exponent).ec == std::errc::result_out_of_range)
            exponent = *digits == '-' ? INT64_MIN : INT64_MAX;
    }
    return std::clamp(exponent, INT64_MIN / 2, INT64_MAX / 2) + (hex ? 4 : 1) * (point - first) > 0;
}

} // namespace

const char *separator_name(char separator) noexcept {
    return separator == ';'    ? "semicolons"
           : separator == ','  ? "commas"
           : separator == '\t' ? "tabs"
           : separator == '|'  ? "bars"
                               : "white space";
}

char separator_of(std::string_view line) {
    const std::string text = masked(line);
    for (const char separator : {';', '|'})
        if (text.find(separator) != kNone)
            return separator;
    const bool has_comma = text.find(',') != kNone;
    if (text.find('\t') == kNone || text.find_first_not_of(kSpace) == kNone)
        return has_comma ? ',' : ' ';
    const std::vector<std::string> fields = split(text, '\t');
    const auto is_one = [&](const std::string &field) { // a field with blanks is several
        return (!has_comma || !with_decimal_point(field).empty() || field.find(',') == kNone) &&
               words_of(field).size() == 1;
    };
    const bool tabs = std::all_of(fields.begin(), fields.end(), is_one);
    return tabs ? '\t' : has_comma ? ',' : ' ';
}

std::string trimmed(std::string_view text) {
    text = inner(text);
    const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    return std::string(quoted ? text.substr(1, text.size() - 2) : text);
}

std::vector<std::string> split(std::string_view line, char separator) {
    if (separator == ' ')
        return words_of(line);
    if (separator == '|')
        line = without_borders(line);
    std::vector<std::string> fields;
    fields.reserve(1 + static_cast<size_t>(std::count(line.begin(), line.end(), separator)));
    for (size_t start = 0;;) {
        const size_t length = field_length(line.substr(start), separator);
        fields.push_back(trimmed(line.substr(start, length)));
        start += length + 1;
        if (start > line.size())
            return fields;
    }
}

std::vector<std::string> split_names(std::string_view line, char separator) {
    std::string mask = masked(line);
    const size_t first = std::min(line.find_first_not_of(kSpace), line.size());
    for (size_t at = first; separator == ' ' && at + 1 < line.size(); at++) { // "rv (m/s)" is one name
        const bool opens = line[at + 1] == '(' || line[at + 1] == '[' || line[at + 1] == '{';
        if (is_space(mask[at]) && opens && mask[at + 1] == 'x' && line[first] != line[at + 1])
            mask[at] = 'x';
    }
    std::vector<std::string> names;
    if (separator == '|')
        return split(line, separator);
    for (size_t start = 0; start <= line.size();) {
        if (separator == ' ')
            start = mask.find_first_not_of(kSpace, start);
        if (start == kNone)
            break;
        const size_t end =
            std::min(separator == ' ' ? mask.find_first_of(kSpace, start) : mask.find(separator, start), mask.size());
        names.push_back(trimmed(line.substr(start, end - start)));
        start = end + 1;
    }
    return names.empty() ? std::vector<std::string>{""} : names;
}

std::string_view without_remark(std::string_view line) noexcept {
    bool quoted = false;
    for (size_t at = line.find('#') == kNone ? line.size() : 0; at < line.size(); at++) {
        quoted = quoted != (line[at] == '"');
        if (line[at] == '#' && !quoted && (at == 0 || is_space(line[at - 1])))
            return line.substr(0, at);
    }
    return line;
}

// Published tables have "1.25 +/- 0.03", also with the UTF-8 or the TeX sign, in one column. Elsewhere, as in the name
// of a column, the sign remains.
std::string without_plus_minus(std::string_view line, char separator) {
    std::string text(line);
    if (text.find_first_of("+\xc2\\") == kNone)
        return text;
    for (const std::string_view sign : {"+/-", "+-", "\xc2\xb1", "\\pm"})
        for (size_t at = text.find(sign); at != kNone; at = text.find(sign, at + 1)) {
            const size_t before = text.find_last_not_of(' ', at - (at > 0)),
                         after = text.find_first_not_of(' ', at + sign.size());
            const auto ends_number = [&](size_t place) {
                return place != kNone && (std::strchr("0123456789.", text[place]) != nullptr && text[place] != '\0');
            };
            if (at > 0 && ends_number(before) && ends_number(after))
                text.replace(at, sign.size(), 1, separator);
        }
    return text;
}

bool number_of(const std::string &text, double &value) noexcept {
    const char *at = std::find_if_not(text.data(), text.data() + text.size(), is_space);
    const char *const end = text.data() + text.size();
    const bool negative = at < end && *at == '-';
    at += negative || (at < end && *at == '+') ? 1 : 0;
    const bool hex = end - at > 2 && at[0] == '0' && (at[1] == 'x' || at[1] == 'X');
    at += hex ? 2 : 0;
    if (at == end || *at == '-')
        return false;
    const auto [stop, error] =
        std::from_chars(at, end, value, hex ? std::chars_format::hex : std::chars_format::general);
    if (error == std::errc::result_out_of_range)
        value = is_above_one(at, stop, hex) ? HUGE_VAL : 0;
    value = negative ? -value : value;
    if (error != std::errc::invalid_argument && stop == end)
        return true;
    if (hex || error == std::errc::invalid_argument || (*stop != 'd' && *stop != 'D') || end - stop < 2)
        return false;
    std::string with_e = text; // the exponent of Fortran
    with_e[static_cast<size_t>(stop - text.data())] = 'e';
    return with_e.find_first_of("dD") == kNone && number_of(with_e, value);
}

std::string with_decimal_point(const std::string &text) {
    const size_t comma = text.find(',');
    std::string number = text;
    double value = 0;
    if (comma == kNone || comma + 1 == text.size() || std::strchr("0123456789", text[comma + 1]) == nullptr ||
        !number_of(number.replace(comma, 1, "."), value))
        return "";
    return number;
}

bool is_missing(std::string_view text) {
    static const std::string_view words[] = {
        "",     "nan",   "-",  "--",     "---", "----", "...",  "null", "n/a", "na",           "<na>",        "masked",
        "none", "indef", "..", "nodata", ".",   "n.a.", "-nan", "+nan", "nil", "\xe2\x80\x93", "\xe2\x80\xa6"};
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (text.size() > 8 || (!text.empty() && is_digit(text[0])) || (text.size() > 1 && is_digit(text[1])))
        return false;
    return std::find(std::begin(words), std::end(words), lower(text)) != std::end(words);
}

bool is_column_name(const std::string &field) {
    double number = 0;
    return field.empty() || (std::strchr("0123456789+-.", field[0]) == nullptr && !number_of(field, number));
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char &c : result)
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return result;
}

std::string in_ascii(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c >= 0x80; }, '?');
    return text;
}

std::string joined(const std::vector<std::string> &words) {
    std::string text;
    for (const std::string &word : words)
        text += (text.empty() ? "" : ",") + word;
    return text;
}

} // namespace toliman::ingest
