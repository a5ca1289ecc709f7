// Method: the first line that is neither empty nor a comment fixes the format of all lines (separator, columns by name
// or by position, or JSON objects). A field must be one number to its last character, so that a damaged number is an
// error and never a shorter number. Values are limited to 1e98 and sigmas to 1e-98 ... 1e98: differences and squares
// then neither overflow nor underflow in double. Dates and days are converted as text, exact to the nanosecond, and
// become Modified Julian Days. UTC becomes TAI, because days of UTC differ in length. The other scales are uniform and
// are kept, so that a barycentric time in TDB stays one.
#include "ingest/series.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kLongest = 65536; // bytes of a line
constexpr size_t kFewest = 2, kMost = 3;
constexpr const char *kNames[kMost] = {"t", "y", "sigma"};
constexpr const char *kDayNames[] = {"mjd", "jd", "MJD", "JD"}; // of time columns that imply the format
constexpr double kLargest = 1e98, kLeastSigma = 1e-98;
constexpr char kSpace[] = " \t\r\v\f";

// Without surrounding white space, and then without surrounding quotes. White space inside remains.
std::string trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos)
        return "";
    text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    return std::string(quoted ? text.substr(1, text.size() - 2) : text);
}

// The length of the first word of a line: up to a blank, but for quotes, and for a date with its time.
size_t word_length(std::string_view line) noexcept {
    const size_t quote = line[0] == '"' ? line.find('"', 1) : std::string_view::npos;
    return quote != std::string_view::npos ? quote + 1 : first_field(line);
}

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (size_t start = line.find_first_not_of(kSpace); start != std::string_view::npos;) {
        const size_t end = start + word_length(line.substr(start));
        words.push_back(trimmed(line.substr(start, end - start)));
        start = line.find_first_not_of(kSpace, end);
    }
    return words.empty() ? std::vector<std::string>{""} : words;
}

// A semicolon if the line has one, otherwise a comma if it has one, otherwise a blank.
char separator_of(std::string_view line) noexcept {
    return line.find(';') != std::string_view::npos ? ';' : line.find(',') != std::string_view::npos ? ',' : ' ';
}

const char *separator_name(char separator) noexcept {
    return separator == ';' ? "semicolons" : separator == ',' ? "commas" : "white space";
}

std::string joined(const std::vector<std::string> &words) {
    std::string text;
    for (const std::string &word : words)
        text += (text.empty() ? "" : ",") + word;
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
            exponent = *digits == '-' ? INT64_MIN / 2 : INT64_MAX / 2;
    }
    return exponent + (hex ? 4 : 1) * (point - first) > 0;
}

// Whether the whole text, with any zero byte in it, is a number as strtod reads it, decimal or hexadecimal; with a
// decimal point in every locale of the host. Numbers beyond the range of double become 0 or
// infinite.
bool number_of(const std::string &text, double &value) noexcept {
    const char *at = text.data() + std::min(text.find_first_not_of(kSpace), text.size());
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
    return error != std::errc::invalid_argument && stop == end;
}

bool decimal_comma(const std::string &field) {
    const size_t comma = field.find(',');
    double value;
    return comma != std::string::npos && comma + 1 < field.size() &&
           number_of(std::string(field).replace(comma, 1, "."), value);
}

// Whether a field is a column name, not a damaged number.
bool is_name(const std::string &field) {
    double number;
    return field.empty() || (std::strchr("0123456789+-.", field[0]) == nullptr && !number_of(field, number));
}

bool is_day_name(const std::string &name) noexcept {
    return std::find(std::begin(kDayNames), std::end(kDayNames), name) != std::end(kDayNames);
}

// The name of the time column by default; has(name): whether there is a column of this name.
template <class Has> std::string default_time_name(Has has) {
    const auto *const found = std::find_if(std::begin(kDayNames), std::end(kDayNames), has);
    return has(kNames[0]) || found == std::end(kDayNames) ? kNames[0] : *found;
}

json::Value object_of(const std::string &line) {
    try {
        return json::parse(line, "is not a JSON object", json::Form::line);
    } catch (const Error &error) {
        fail(error.status(), "%s", error.what()); // without the field, which is not a name
    }
}

// Bytes of a field for messages.
std::string shown(std::string field) {
    std::replace(field.begin(), field.end(), '\0', '?');
    return field;
}

// The range that a value of a column violates; nullptr: none.
const char *flaw_of(double value, size_t column) noexcept {
    if (!std::isfinite(value))
        return "must be a finite number";
    if (column == 2)
        return value >= kLeastSigma && value <= kLargest ? nullptr : "must be in [1e-98, 1e98]";
    return std::fabs(value) > kLargest ? "must be in [-1e98, 1e98]" : nullptr;
}

} // namespace

std::vector<std::string> split(std::string_view line, char separator) {
    if (separator == ' ')
        return words_of(line);
    std::vector<std::string> fields;
    fields.reserve(kMost);
    size_t start = 0;
    for (size_t end; (end = line.find(separator, start)) != std::string_view::npos; start = end + 1)
        fields.push_back(trimmed(line.substr(start, end - start)));
    fields.push_back(trimmed(line.substr(start)));
    return fields;
}

std::optional<Sample> Series::parse(std::string_view line) {
    try {
        const std::optional<Sample> sample = parse_line(line);
        lines_++;
        return sample;
    } catch (const Error &error) {
        const long long number = lines_ + 1;
        if (error.status() == Status::format)
            lines_++;
        if (options_.name.empty())
            throw;
        fail_within(error, error.status(), "{%s}:%lld: %s", options_.name.c_str(), number, error.what());
    }
}

std::optional<Sample> Series::parse_line(std::string_view line) {
    const bool whole = !line.empty() && line.back() == '\n';
    line.remove_suffix(whole ? 1 : 0);
    if (lines_ == 0 && line.substr(0, 3) == "\xef\xbb\xbf") // the byte order mark that some editors write
        line.remove_prefix(3);
    const size_t text = line.find_first_not_of(" \t\r");
    if (text == std::string_view::npos || line[text] == '#')
        return std::nullopt;
    if (line.size() > kLongest)
        fail(Status::format, "is longer than %zu bytes", kLongest);
    if (options_.growing && !whole)
        fail(Status::format, "has no newline at its end and may be truncated");
    if (line[text] == '{')
        return parse_object(std::string(line));
    if (!known_)
        separator_ = separator_of(line);
    const std::vector<std::string> fields = split(line, separator_);
    if ((fields.size() == 1 && fields[0].empty()) || fields[0][0] == '#')
        return std::nullopt;
    const std::optional<Sample> sample = parse_fields(fields, line);
    truncated_ = sample ? !whole : truncated_;
    return sample;
}

// Empty for the line of names.
std::optional<Sample> Series::parse_fields(const std::vector<std::string> &fields, std::string_view line) {
    if (objects_)
        fail(Status::format, "is not a JSON object: the lines before are");
    if (!known_ && fields.size() >= kFewest && is_name(fields[0]) && is_name(fields[1])) {
        use_names(fields);
        return std::nullopt;
    }
    if (!known_)
        use_positions(fields.size());
    if (fields.size() != width_ && separator_of(line) != separator_)
        fail(Status::format, "has columns separated by %s: the lines before have %s",
             separator_name(separator_of(line)), separator_name(separator_));
    if (fields.size() != width_)
        fail(Status::format, "has %zu columns: the lines before have %zu", fields.size(), width_);
    const std::string &time = fields[columns_[0]];
    use_times(time_name_, time);
    double values[kMost] = {format_ ? day_of(time) : value_of(time, 0), 0, 0};
    for (size_t i = 1; i < columns_.size(); i++)
        values[i] = value_of(fields[columns_[i]], i);
    known_ = times_known_ = true;
    return Sample{values[0], values[1], values[2]};
}

// {"t": 1, "y": 2, "sigma": 0.1}; other keys are ignored.
Sample Series::parse_object(const std::string &line) {
    if (known_ && !objects_)
        fail(Status::format, "is a JSON object: the lines before are not");
    const json::Value object = object_of(line);
    const std::vector<std::string> &wanted = options_.columns;
    const auto has = [&](const char *name) { return object.find(name) != nullptr; };
    double values[kMost] = {0, 0, 0};
    std::vector<size_t> columns;
    for (size_t i = 0; i < (wanted.empty() ? kMost : wanted.size()); i++) {
        const std::string name = !wanted.empty() ? wanted[i] : i == 0 ? default_time_name(has) : kNames[i];
        const json::Value *const value = object.find(name);
        if (value == nullptr && i >= kFewest && wanted.empty())
            break;
        columns.push_back(i);
        if (i == 0) {
            values[0] = time_of(name, value);
            continue;
        }
        if (value == nullptr || value->kind != json::Value::Kind::number)
            fail(Status::format, "{%s}: must be a number", name.c_str());
        values[i] = value->number;
        if (const char *const flaw = flaw_of(values[i], i))
            fail(Status::format, "{%s} = %g: %s", name.c_str(), values[i], flaw);
    }
    if (objects_ && columns.size() != columns_.size())
        fail(Status::format, "has other keys than the lines before: either all or none must have sigma");
    columns_ = std::move(columns);
    known_ = objects_ = times_known_ = true;
    return {values[0], values[1], values[2]};
}

void Series::use_names(const std::vector<std::string> &fields) {
    const std::vector<std::string> &wanted = options_.columns;
    const auto has = [&](const char *name) { return std::find(fields.begin(), fields.end(), name) != fields.end(); };
    const std::vector<std::string> names =
        wanted.empty() ? std::vector<std::string>{default_time_name(has), kNames[1], kNames[2]} : wanted;
    std::vector<size_t> columns;
    for (const std::string &name : names) {
        const auto found = std::find(fields.begin(), fields.end(), name);
        if (found != fields.end())
            columns.push_back(static_cast<size_t>(found - fields.begin()));
        else if (!wanted.empty() || columns.size() < kFewest)
            fail(Status::mismatch, "has no column {%s} among %s", name.c_str(), joined(fields).c_str());
    }
    time_name_ = names[0];
    columns_ = std::move(columns);
    width_ = fields.size();
    known_ = true;
}

void Series::use_positions(size_t count) {
    if (!options_.columns.empty())
        fail(Status::mismatch, "has no column names: the first line must name %s", joined(options_.columns).c_str());
    if (count < kFewest || count > kMost)
        fail(Status::format,
             "has %zu %s, separated by %s: must be t,y or t,y,sigma, or the first line must name the columns", count,
             count == 1 ? "column" : "columns", separator_name(separator_));
    columns_.clear();
    for (size_t i = 0; i < count; i++)
        columns_.push_back(i);
    width_ = count;
}

// Until the first sample is complete, each line determines the format of the times.
void Series::use_times(const std::string &column, const std::string &first) {
    if (times_known_)
        return;
    format_ = options_.format;
    if (format_ || options_.plain_times)
        return;
    if (begins_with_date(first))
        format_ = TimeFormat::iso;
    else if (is_day_name(column))
        format_ = column.size() == 2 ? TimeFormat::jd : TimeFormat::mjd;
}

// The time of an object is a number, or a string with a date.
double Series::time_of(const std::string &name, const json::Value *value) {
    using Kind = json::Value::Kind;
    if (value == nullptr || (value->kind != Kind::number && value->kind != Kind::text))
        fail(Status::format, "{%s}: must be a number", name.c_str());
    char digits[32];
    print_text(digits, sizeof digits, "%.17g", value->number);
    const std::string text = value->kind == Kind::text ? value->text : digits;
    use_times(name, text);
    if (format_)
        return day_of(text);
    if (value->kind == Kind::text)
        fail(Status::format, "{%s}: must be a number", name.c_str());
    return value_of(text, 0);
}

// Modified Julian Day of scale().
double Series::day_of(const std::string &text) const {
    constexpr int64_t kDay = 86400000000000, kDayOf1970 = 40587;
    if (text.find('\0') != std::string::npos)
        fail(Status::format, "{%s}: contains a zero byte", kNames[0]);
    try {
        const Scale kept = options_.scale == Scale::utc ? Scale::utc : Scale::tai; // no conversion of other scales
        const int64_t ns = parse_time(text.c_str(), *format_, kept, options_.leap_seconds);
        const int64_t days = ns / kDay - (ns % kDay < 0);
        return static_cast<double>(kDayOf1970 + days) +
               static_cast<double>(ns - days * kDay) / static_cast<double>(kDay);
    } catch (const Error &error) {
        fail(Status::format, "{%s}: %s", kNames[0], error.what());
    }
}

double Series::value_of(const std::string &field, size_t column) const {
    double value;
    const bool number = number_of(field, value);
    const char *const flaw = flaw_of(number ? value : NAN, column);
    if (flaw == nullptr)
        return value;
    const bool separated = field.find_first_of(separator_ == ' ' ? ",;" : ",; \t") != std::string::npos;
    const char *const hint = decimal_comma(field)   ? " with a decimal point, not a decimal comma"
                             : !number && separated ? "; columns are separated by "
                                                    : "";
    fail(Status::format, "{%s} = \"%.60s\": %s%s%s", kNames[column], shown(field).c_str(), flaw, hint,
         hint[0] == ';' ? separator_name(separator_) : "");
}

} // namespace toliman::ingest
