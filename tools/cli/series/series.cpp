// Method: the first line that is neither empty nor a comment fixes the format for the whole file (separator, columns by
// name or by position, or JSON objects); every later line must have the same. A field must be one number to its last
// character, so that a damaged number is an error and never a shorter number. Values are limited to 1e98 and sigmas to
// 1e-98 ... 1e98: differences and squares then neither overflow nor underflow in double.
#include "series/series.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sys/stat.h>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/npy.hpp"
#include "common/text.hpp"
#include "series/columns.hpp"

namespace cli {

namespace {

constexpr size_t kFewest = 2, kMost = 3; // number of columns
constexpr const char *kNames[kMost] = {"t", "y", "sigma"};
constexpr double kLargest = 1e98, kLeastSigma = 1e-98; // their squares and differences are within the range of double

// The range that a value of a column violates; nullptr: none.
constexpr const char *kNoNumber = "must be a finite number";
const char *flaw_of(double value, size_t column) noexcept {
    if (!std::isfinite(value))
        return kNoNumber;
    if (column == 2 && !(value >= kLeastSigma && value <= kLargest))
        return "must be in [1e-98, 1e98]";
    return std::fabs(value) > kLargest ? "must be in [-1e98, 1e98]" : nullptr;
}

// Whether a field is a column name, not a damaged number.
bool is_name(const std::string &field) {
    double number;
    return field.empty() || (std::strchr("0123456789+-.", field[0]) == nullptr && !number_of(field, number));
}

} // namespace

bool SampleReader::next(Sample &sample) {
    for (std::string line; in_.next(line);) {
        number_++;
        if (number_ == 1)
            begin(line);
        const size_t text = line.find_first_not_of(" \t\r");
        if (text == std::string::npos || line[text] == '#')
            continue;
        if (line.size() > LineSource::kLongest)
            bad("is longer than " + std::to_string(LineSource::kLongest) + " bytes");
        if (complete_ && !in_.whole())
            bad("has no newline at its end and may be truncated");
        if (line[text] == '{') {
            parse_object(line, sample);
            return true;
        }
        if (!format_known_)
            separator_ = separator_of(line);
        const std::vector<std::string> fields = split(line, separator_);
        const bool empty = fields.size() == 1 && fields[0].empty();
        if (empty || fields[0][0] == '#')
            continue;
        if (parse_fields(fields, line, sample)) {
            truncated_ = !in_.whole();
            return true;
        }
    }
    return false;
}

// Recognises other formats, and removes the byte order mark U+FEFF that some editors write.
void SampleReader::begin(std::string &line) const {
    if (line.compare(0, 6, "\x93NUMPY") == 0)
        malformed(name(), "is a .npy file: give its name, without --follow and --from-state");
    if (line.compare(0, 4, "TLMP") == 0)
        malformed(name(), "is a saved state: give it to --from-state");
    if (line.compare(0, 3, "\xef\xbb\xbf") == 0)
        line.erase(0, 3);
}

// False for the line of names.
bool SampleReader::parse_fields(const std::vector<std::string> &fields, const std::string &line, Sample &sample) {
    if (objects_)
        bad("is not a JSON object: the lines before are");
    if (!format_known_ && fields.size() >= kFewest && is_name(fields[0]) && is_name(fields[1])) {
        use_names(fields);
        return false;
    }
    if (!format_known_)
        use_positions(fields.size());
    if (fields.size() != width_ && separator_of(line) != separator_)
        bad("has columns separated by " + std::string(separator_name(separator_of(line))) + ": the lines before have " +
            separator_name(separator_));
    if (fields.size() != width_)
        bad("has " + std::to_string(fields.size()) + " columns: the lines before have " + std::to_string(width_));
    double values[kMost] = {0, 0, 1};
    for (size_t i = 0; i < columns_.size(); i++)
        values[i] = value_of(fields[columns_[i]], i);
    format_known_ = true;
    sample = {values[0], values[1], values[2]};
    return true;
}

// {"t": 1, "y": 2, "sigma": 0.1}; other keys are ignored.
void SampleReader::parse_object(const std::string &line, Sample &sample) {
    if (format_known_ && !objects_)
        bad("is a JSON object: the lines before are not");
    const JsonTree object(cJSON_ParseWithOpts(line.c_str(), nullptr, true));
    if (!object || line.find('\0') != std::string::npos) // cJSON would stop at the NUL
        bad("is not a JSON object");
    double values[kMost] = {0, 0, 1};
    std::vector<size_t> columns;
    for (size_t i = 0; i < kMost && (wanted_.empty() || i < wanted_.size()); i++) {
        const std::string name = wanted_.empty() ? kNames[i] : wanted_[i];
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(object.get(), name.c_str());
        if (item == nullptr && i >= kFewest && wanted_.empty())
            break;
        if (cJSON_IsNumber(item) == 0)
            bad(name + ": must be a number");
        values[i] = item->valuedouble;
        if (const char *flaw = flaw_of(values[i], i))
            bad(name + " = " + std::to_string(values[i]) + ": " + flaw);
        columns.push_back(i);
    }
    if (objects_ && columns.size() != columns_.size())
        bad("has other keys than the lines before: either all or none must have sigma");
    format_known_ = objects_ = true;
    columns_ = columns;
    sample = {values[0], values[1], values[2]};
}

void SampleReader::use_names(const std::vector<std::string> &fields) {
    const std::vector<std::string> names = wanted_.empty() ? std::vector<std::string>(kNames, kNames + kMost) : wanted_;
    columns_.clear();
    for (const std::string &name : names) {
        const auto found = std::find(fields.begin(), fields.end(), name);
        if (found != fields.end())
            columns_.push_back(static_cast<size_t>(found - fields.begin()));
        else if (!wanted_.empty() || columns_.size() < kFewest)
            bad_file("has no column " + name + " among " + joined(fields, ",") +
                     ": name the columns with --columns T,Y or T,Y,SIGMA");
    }
    width_ = fields.size();
    format_known_ = true;
}

void SampleReader::use_positions(size_t count) {
    if (!wanted_.empty())
        bad_file("has no column names: --columns " + joined(wanted_, ",") + " needs a first line with names");
    if (count < kFewest || count > kMost)
        bad("has " + std::to_string(count) + (count == 1 ? " column" : " columns") + ", separated by " +
            separator_name(separator_) + ": must be t,y or t,y,sigma, or the first line must name the columns");
    columns_.clear();
    for (size_t i = 0; i < count; i++)
        columns_.push_back(i);
    width_ = count;
}

double SampleReader::value_of(const std::string &field, size_t column) const {
    double value;
    const bool number = number_of(field, value);
    const char *flaw = number ? flaw_of(value, column) : kNoNumber;
    if (flaw == nullptr)
        return value;
    std::string why = kNames[column] + (" = \"" + field + "\": ") + flaw;
    if (decimal_comma(field))
        why += " with a decimal point, not a decimal comma";
    else if (!number && field.find_first_of(separator_ == ' ' ? ",;" : ",; \t") != std::string::npos)
        why += std::string("; columns are separated by ") + separator_name(separator_);
    bad(why);
}

namespace {

// Regular files only: bytes that are read from a pipe cannot be read again.
bool is_npy(const std::string &name) {
    char magic[6] = {};
    struct stat status = {};
    return ::stat(name.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
           std::ifstream(name, std::ios::binary).read(magic, sizeof magic) &&
           std::memcmp(magic, "\x93NUMPY", sizeof magic) == 0;
}

Series read_npy_series(const std::string &name) {
    InputFile file(name);
    const toliman::NpyHeader header = read_npy_header(file);
    if (header.type != "f8" || header.shape.size() != 2 || header.shape[1] < kFewest || header.shape[1] > kMost)
        malformed(name, "must be a float64 array of shape [samples][2 or 3]: t, y and sigma");
    const size_t rows = header.shape[0], cols = header.shape[1];
    if (rows == 0)
        malformed(name, "contains no samples");
    const bool fits = rows <= (file.size() - header.size) / (cols * sizeof(double));
    std::vector<double> numbers(fits ? rows * cols : 0);
    if (!fits || !file.read(numbers.data(), numbers.size() * sizeof numbers[0]))
        malformed(name, "is truncated: it is shorter than its header states");
    Series series;
    series.name = name;
    for (size_t i = 0; i < rows; i++) {
        const double *row = &numbers[i * cols];
        for (size_t k = 0; k < cols; k++)
            if (const char *flaw = flaw_of(row[k], k))
                malformed(name,
                          "row " + std::to_string(i) + ", " + kNames[k] + " = " + std::to_string(row[k]) + ": " + flaw);
        series.t.push_back(row[0]);
        series.y.push_back(row[1]);
        if (cols == kMost)
            series.sigma.push_back(row[2]);
    }
    return series;
}

} // namespace

Series read_series(const std::string &name, const std::vector<std::string> &columns) {
    need(name, "a series of t, y[, sigma]", // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    if (is_npy(name))
        return read_npy_series(name);
    SampleReader reader(name, columns);
    Series series;
    series.name = reader.name();
    for (Sample sample = {}; reader.next(sample);) {
        series.t.push_back(sample.t);
        series.y.push_back(sample.y);
        if (reader.weighted())
            series.sigma.push_back(sample.sigma);
    }
    if (reader.truncated())
        series.warning = reader.where() + kTruncatedWarning;
    if (series.t.empty())
        malformed(series.name, reader.empty() ? "is empty" : "contains no samples");
    return series;
}

} // namespace cli
