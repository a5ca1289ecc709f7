// Method: the first line that is neither empty nor a comment fixes the format for the whole file (separator, columns by
// name or by position, or JSON objects); every later line must have the same. A field must be one number to its last
// character, so that a damaged number is an error and never a shorter number. Values are limited to 1e98 and sigmas to
// 1e-98 ... 1e98: differences and squares then neither overflow nor underflow in double.
#include "series/sample_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/json.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr double kLargest = 1e98, kLeastSigma = 1e-98; // their squares and differences are within the range of double

constexpr const char *kNoNumber = "must be a finite number";

constexpr char kSpace[] = " \t\r\v\f";

// Without surrounding white space, and then without surrounding quotes. White space inside remains.
std::string trimmed(const std::string &text) {
    const size_t first = text.find_first_not_of(kSpace);
    if (first == std::string::npos)
        return "";
    const std::string word = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    const bool quoted = word.size() >= 2 && word.front() == '"' && word.back() == '"';
    return quoted ? word.substr(1, word.size() - 2) : word;
}

std::vector<std::string> words_of(const std::string &line) {
    std::vector<std::string> words;
    for (size_t start = line.find_first_not_of(kSpace); start != std::string::npos;) {
        const size_t end = line.find_first_of(kSpace, start);
        words.push_back(trimmed(line.substr(start, end - start)));
        start = line.find_first_not_of(kSpace, end);
    }
    return words.empty() ? std::vector<std::string>{""} : words;
}

// The separator of a file's columns, from its first line that is neither empty nor a comment: a semicolon if the line
// has one, otherwise a comma if it has one, otherwise a blank for white space (any number of blanks and tabs).
char separator_of(const std::string &line) {
    if (line.find(';') != std::string::npos)
        return ';';
    return line.find(',') != std::string::npos ? ',' : ' ';
}

const char *separator_name(char separator) noexcept {
    return separator == ';' ? "semicolons" : separator == ',' ? "commas" : "white space";
}

// Whether the field is a number with a decimal comma.
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

// The name of the time column unless --columns gives one; has(name): whether there is a column of this name.
template <class Has> std::string default_time_name(Has has) {
    const auto found = std::find_if(std::begin(kDayNames), std::end(kDayNames), has);
    return has(kSampleNames[0]) || found == std::end(kDayNames) ? kSampleNames[0] : *found;
}

} // namespace

std::vector<std::string> split(const std::string &line, char separator) {
    if (separator == ' ')
        return words_of(line);
    std::vector<std::string> fields;
    fields.reserve(3);
    size_t start = 0;
    for (size_t end; (end = line.find(separator, start)) != std::string::npos; start = end + 1)
        fields.push_back(trimmed(line.substr(start, end - start)));
    fields.push_back(trimmed(line.substr(start)));
    return fields;
}

const char *flaw_of(double value, size_t column) noexcept {
    if (!std::isfinite(value))
        return kNoNumber;
    if (column == 2 && !(value >= kLeastSigma && value <= kLargest))
        return "must be in [1e-98, 1e98]";
    return std::fabs(value) > kLargest ? "must be in [-1e98, 1e98]" : nullptr;
}

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
    if (!format_known_ && fields.size() >= kFewestColumns && is_name(fields[0]) && is_name(fields[1])) {
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
    double values[kMostColumns] = {time_of(time_name_, fields[columns_[0]]), 0, 1};
    for (size_t i = 1; i < columns_.size(); i++)
        values[i] = value_of(fields[columns_[i]], i);
    format_known_ = times_known_ = true;
    sample = {values[0], values[1], values[2]};
    return true;
}

// Until the first sample is complete, each line determines the format of the times.
double SampleReader::time_of(const std::string &name, const std::string &field) {
    if (!times_known_)
        times_.begin(name, field);
    if (times_.plain())
        return value_of(field, 0);
    try {
        return times_.day_of(field);
    } catch (const Failure &failure) {
        bad(kSampleNames[0] + (": " + std::string(failure.what())));
    }
}

// The time of an object is a number, or a string with a date.
double SampleReader::time_of(const std::string &name, const cJSON *item) {
    if (cJSON_IsNumber(item) == 0 && cJSON_IsString(item) == 0)
        bad(name + ": must be a number");
    const bool is_text = cJSON_IsString(item) != 0;
    const double time = time_of(name, is_text ? item->valuestring : formatted("%.17g", item->valuedouble));
    if (is_text && times_.plain())
        bad(name + ": must be a number");
    return time;
}

// {"t": 1, "y": 2, "sigma": 0.1}; other keys are ignored.
void SampleReader::parse_object(const std::string &line, Sample &sample) {
    if (format_known_ && !objects_)
        bad("is a JSON object: the lines before are not");
    const JsonTree object(cJSON_ParseWithOpts(line.c_str(), nullptr, true));
    if (!object || line.find('\0') != std::string::npos) // cJSON would stop at the NUL
        bad("is not a JSON object");
    const auto item_of = [&](const char *name) { return cJSON_GetObjectItemCaseSensitive(object.get(), name); };
    double values[kMostColumns] = {0, 0, 1};
    std::vector<size_t> columns;
    for (size_t i = 0; i < kMostColumns && (wanted_.empty() || i < wanted_.size()); i++) {
        const auto has = [&](const char *name) { return item_of(name) != nullptr; };
        const std::string name = !wanted_.empty() ? wanted_[i] : i == 0 ? default_time_name(has) : kSampleNames[i];
        const cJSON *item = item_of(name.c_str());
        if (i == 0) {
            values[0] = time_of(name, item);
            columns.push_back(0);
            continue;
        }
        if (item == nullptr && i >= kFewestColumns && wanted_.empty())
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
    format_known_ = objects_ = times_known_ = true;
    columns_ = columns;
    sample = {values[0], values[1], values[2]};
}

void SampleReader::use_names(const std::vector<std::string> &fields) {
    const auto has = [&](const char *name) { return std::find(fields.begin(), fields.end(), name) != fields.end(); };
    const std::vector<std::string> names =
        wanted_.empty() ? std::vector<std::string>{default_time_name(has), kSampleNames[1], kSampleNames[2]} : wanted_;
    time_name_ = names[0];
    columns_.clear();
    for (const std::string &name : names) {
        const auto found = std::find(fields.begin(), fields.end(), name);
        if (found != fields.end())
            columns_.push_back(static_cast<size_t>(found - fields.begin()));
        else if (!wanted_.empty() || columns_.size() < kFewestColumns)
            bad_file("has no column " + name + " among " + joined(fields, ",") +
                     ": name the columns with --columns T,Y or T,Y,SIGMA");
    }
    width_ = fields.size();
    format_known_ = true;
}

void SampleReader::use_positions(size_t count) {
    if (!wanted_.empty())
        bad_file("has no column names: --columns " + joined(wanted_, ",") + " needs a first line with names");
    if (count < kFewestColumns || count > kMostColumns)
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
    std::string why = kSampleNames[column] + (" = \"" + field + "\": ") + flaw;
    if (decimal_comma(field))
        why += " with a decimal point, not a decimal comma";
    else if (!number && field.find_first_of(separator_ == ' ' ? ",;" : ",; \t") != std::string::npos)
        why += std::string("; columns are separated by ") + separator_name(separator_);
    bad(why);
}

} // namespace cli
