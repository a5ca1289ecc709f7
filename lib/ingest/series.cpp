// Method: a header, or the first row, fixes the layout of all rows (table_header.cpp): columns by name or by position,
// or JSON objects. Values are limited to 1e98 and sigmas to 1e-98 ... 1e98: differences and squares then neither
// overflow nor underflow in double. A row that lacks t, y or sigma is counted and skipped; what is neither a number nor
// a word for a missing value is an error. Sigmas are converted to the unit of y.
#include "ingest/series.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/fields.hpp"
#include "ingest/series_values.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kLongest = 65536; // bytes of a line
// Bytes of a field for messages.
std::string shown(std::string field) {
    std::replace(field.begin(), field.end(), '\0', '?');
    return field;
}

std::string name_or_number(const std::string &name, size_t place) {
    return name.empty() ? std::to_string(place + 1) : name;
}

bool begins_array(std::string_view line) noexcept {
    const size_t next = line.find_first_not_of(" \t\r", 1);
    return line[0] == '[' && (next == line.npos || line[next] == '{');
}

} // namespace

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

std::vector<std::string> Series::take_warnings() {
    const std::vector<std::string> next(warnings_.begin() + static_cast<int64_t>(taken_), warnings_.end());
    taken_ = warnings_.size();
    return next;
}

void Series::warn(const std::string &text) {
    const std::string warning = (options_.name.empty() ? "series" : options_.name) + ": " + text;
    if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end())
        warnings_.push_back(warning);
}

std::optional<Sample> Series::parse_line(std::string_view line) {
    const bool whole = !line.empty() && line.back() == '\n';
    line.remove_suffix(whole ? 1 : 0);
    if (lines_ == 0 && line.substr(0, 3) == "\xef\xbb\xbf") // the byte order mark that some editors write
        line.remove_prefix(3);
    const size_t text = line.find_first_not_of(" \t\r");
    if (text == std::string_view::npos)
        return std::nullopt;
    if (line[text] == '#') {
        header_.comment(line);
        return std::nullopt;
    }
    if (line.size() > kLongest)
        fail(Status::format, "is longer than %zu bytes", kLongest);
    if (options_.growing && !whole)
        fail(Status::format, "has no newline at its end and may be truncated");
    if (line[text] == '{')
        return parse_object(std::string(line));
    if (!known_ && begins_array(line.substr(text)))
        fail(Status::format, "begins a JSON array, which only a whole file may contain: must be an object per line");
    const TableHeader::Line kind = objects_ ? TableHeader::Line::row : header_.take(line);
    if (kind == TableHeader::Line::names)
        use_names();
    if (kind != TableHeader::Line::row)
        return std::nullopt;
    const int64_t missing = missing_;
    const std::optional<Sample> sample = parse_row(line);
    truncated_ = sample || missing_ > missing ? !whole : truncated_;
    return sample;
}

// Empty for a row without a value.
std::optional<Sample> Series::parse_row(std::string_view line) {
    const std::vector<std::string> fields = header_.fields(line);
    if ((fields.size() == 1 && fields[0].empty()) || fields[0].substr(0, 1) == "#")
        return std::nullopt;
    if (objects_)
        fail(Status::format, "is not a JSON object: the lines before are");
    if (!known_)
        use_columns(fields.size());
    check_width(fields, line);
    const bool is_row = known_ || !is_missing(fields[places_.t]);
    if (is_row && (lacks(fields, places_.t) || lacks(fields, places_.y) || lacks(fields, places_.sigma))) {
        known_ = true;
        missing_++;
        return std::nullopt;
    }
    if (!begun_)
        use_units(header_.columns());
    const std::string time = with_point(fields[places_.t], 0);
    const std::string warning = times_.use_first(time);
    const double t = times_.format() ? times_.day_of(time) : value_of(time, 0);
    const double y = value_of(with_point(fields[places_.y], 1), 1);
    const double sigma = places_.sigma != kNoPlace ? value_of(with_point(fields[places_.sigma], 2), 2) : 0;
    const Sample sample = sample_of(t, y, sigma, instrument_ != kNoPlace ? &fields[instrument_] : nullptr);
    see_instruments(names_, fields);
    if (!warning.empty())
        warn(warning);
    header_.begin_rows();
    return sample;
}

Sample Series::sample_of(double t, double y, double sigma, const std::string *instrument) {
    const double values[kSeriesMost] = {t, y, sigma}, converted = sigma * sigma_factor_;
    if (sigma > 0 && flaw_of(converted, 2) != nullptr)
        fail(Status::format, "{sigma} = %g in the unit of y: %s", converted, flaw_of(converted, 2));
    for (size_t i = 0; i < (sigma > 0 ? kSeriesMost : kSeriesFewest); i++)
        marks_.add(i, values[i], lines_ + 1);
    const bool is_known = instrument != nullptr && !is_missing(*instrument);
    known_ = begun_ = true;
    times_.settle();
    return {t, y, converted, is_known ? instruments_.index_of(*instrument) : -1};
}

bool Series::lacks(const std::vector<std::string> &fields, size_t place) const {
    if (place == kNoPlace)
        return false;
    const std::string &null = header_.columns()[place].null;
    double value = 0, marked = 0;
    const bool is_null =
        !null.empty() &&
        (fields[place] == null || (number_of(null, marked) && number_of(fields[place], value) && value == marked));
    return is_null || is_missing(fields[place]);
}

void Series::check_width(const std::vector<std::string> &fields, std::string_view line) const {
    const size_t width = header_.columns().size();
    if (fields.size() == width)
        return;
    const char found = separator_of(line), separator = header_.separator();
    if (found != separator && !header_.is_fixed() && separator != '|')
        fail(Status::format, "has columns separated by %s: the lines before have %s", separator_name(found),
             separator_name(separator));
    fail(Status::format, "has %zu columns: the lines before have %zu", fields.size(), width);
}

// With a decimal point instead of a decimal comma, which a series has in all numbers or in none.
std::string Series::with_point(const std::string &field, size_t column) {
    if (header_.separator() == ',' || (point_ == '.' && field.find(',') == field.npos))
        return field;
    const std::string number = with_decimal_point(field);
    double value = 0;
    const bool has_point = field.find('.') != field.npos && number_of(field, value);
    if (has_point && point_ == ',')
        fail(Status::format, "{%s} = \"%.60s\": must have a decimal comma, as the numbers before",
             kSeriesColumns[column], field.c_str());
    if (has_point)
        point_ = '.';
    if (number.empty() || point_ == '.')
        return field;
    point_ = ',';
    return number;
}

double Series::value_of(const std::string &field, size_t column) const {
    double value = 0;
    const bool number = number_of(field, value);
    const char *const flaw = flaw_of(number ? value : NAN, column);
    if (flaw == nullptr)
        return value;
    const char separator = header_.separator();
    const bool separated = field.find_first_of(separator == ' ' ? ",;" : ",; \t") != std::string::npos;
    const char *const hint = !with_decimal_point(field).empty() ? " with a decimal point, not a decimal comma"
                             : !number && separated             ? "; columns are separated by "
                                                                : "";
    fail(Status::format, "{%s} = \"%.60s\": %s%s%s", kSeriesColumns[column], shown(field).c_str(), flaw, hint,
         hint[0] == ';' ? separator_name(separator) : "");
}

void Series::see_instruments(const std::vector<std::string> &names, const std::vector<std::string> &fields) {
    if (instrument_ != kNoPlace)
        return;
    for (size_t i = 0; i < std::min(fields.size(), LikelyInstrument::kMostColumns); i++)
        if (i != places_.t && i != places_.y && i != places_.sigma)
            likely_.add(name_or_number(names[i], i), fields[i]);
}

} // namespace toliman::ingest
