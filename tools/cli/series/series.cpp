#include "series/series.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sys/stat.h>
#include <utility>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/lines.hpp"
#include "common/npy.hpp"
#include "common/terminal.hpp"
#include "series/columns.hpp"

namespace cli {

namespace {

constexpr size_t kFewest = 2, kMost = 3; // columns that are read
constexpr const char *kNames[kMost] = {"t", "y", "sigma"};
constexpr double kLargest = 1e98, kLeastSigma = 1e-98; // squares and differences of these keep within double

// What is wrong with a value in one of the columns; nullptr: nothing.
constexpr const char *kNoNumber = "must be a finite number";
const char *flaw_of(double value, size_t column) noexcept {
    if (!std::isfinite(value))
        return kNoNumber;
    if (column == 2 && !(value >= kLeastSigma && value <= kLargest))
        return "must be above 0, from 1e-98 to 1e98";
    return std::fabs(value) > kLargest ? "must be within -1e98 to 1e98" : nullptr;
}

// A name of a column, not a damaged number.
bool heading(const std::string &field) {
    double number;
    return field.empty() || (std::strchr("0123456789+-.", field[0]) == nullptr && !number_of(field, number));
}

} // namespace

class SampleReader::Lines {
  public:
    Lines(const std::string &path, const std::vector<std::string> &columns, bool whole, std::function<void()> awake)
        : in_(path, std::move(awake)), wanted_(columns), whole_(whole) {}

    bool next(Sample &sample) {
        for (std::string line; in_.next(line);) {
            number_++;
            if (number_ == 1)
                begin(line);
            const size_t text = line.find_first_not_of(" \t\r");
            if (text == std::string::npos || line[text] == '#')
                continue;
            if (line.size() > LineSource::kLongest)
                bad("is longer than " + std::to_string(LineSource::kLongest) + " bytes");
            if (whole_ && !in_.whole())
                bad("ends without a newline and may be cut");
            if (line[text] == '{') {
                take_object(line, sample);
                return true;
            }
            if (!settled_)
                separator_ = separator_of(line);
            const std::vector<std::string> fields = split(line, separator_);
            const bool empty = fields.size() == 1 && fields[0].empty();
            if (empty || fields[0][0] == '#')
                continue;
            if (take(fields, line, sample)) {
                cut_ = !in_.whole();
                return true;
            }
        }
        return false;
    }

    const std::string &name() const noexcept { return in_.name(); }
    std::string where() const { return in_.name() + ":" + std::to_string(number_); }
    bool weighted() const noexcept { return at_.size() == kMost; }
    bool empty() const noexcept { return number_ == 0; }
    bool cut() const noexcept { return cut_; }

  private:
    // This line is no sample.
    [[noreturn]] void bad(const std::string &why) const { throw BadLine(where() + ": " + why); }
    // Nor will any line after it be.
    [[noreturn]] void hopeless(const std::string &why) const { malformed(where(), why); }

    // Editors of some systems put a mark before the text, U+FEFF.
    void begin(std::string &line) const {
        if (line.compare(0, 6, "\x93NUMPY") == 0)
            malformed(name(), "is a .npy file: give it by its name, without --follow and --from-state");
        if (line.compare(0, 4, "TLMP") == 0)
            malformed(name(), "is a saved state: --from-state takes it");
        if (line.compare(0, 3, "\xef\xbb\xbf") == 0)
            line.erase(0, 3);
    }

    // False for a line of names.
    bool take(const std::vector<std::string> &fields, const std::string &line, Sample &sample) {
        if (objects_)
            bad("is no JSON object, as the lines before");
        if (!settled_ && fields.size() >= kFewest && heading(fields[0]) && heading(fields[1])) {
            take_names(fields);
            return false;
        }
        if (!settled_)
            take_positions(fields.size());
        if (fields.size() != width_ && separator_of(line) != separator_)
            bad("has columns separated by " + std::string(name_of(separator_of(line))) + ": the lines before have " +
                name_of(separator_));
        if (fields.size() != width_)
            bad("has " + std::to_string(fields.size()) + " columns: the lines before have " + std::to_string(width_));
        double values[kMost] = {0, 0, 1};
        for (size_t i = 0; i < at_.size(); i++)
            values[i] = value_of(fields[at_[i]], i);
        settled_ = true;
        sample = {values[0], values[1], values[2]};
        return true;
    }

    // {"t": 1, "y": 2, "sigma": 0.1} and whatever else.
    void take_object(const std::string &line, Sample &sample) {
        if (settled_ && !objects_)
            bad("is a JSON object, the lines before are not");
        const JsonTree object(cJSON_ParseWithOpts(line.c_str(), nullptr, true));
        if (!object || line.find('\0') != std::string::npos) // for cJSON the text ends there
            bad("is no JSON object");
        double values[kMost] = {0, 0, 1};
        std::vector<size_t> at;
        for (size_t i = 0; i < kMost && (wanted_.empty() || i < wanted_.size()); i++) {
            const std::string name = wanted_.empty() ? kNames[i] : wanted_[i];
            const cJSON *item = cJSON_GetObjectItemCaseSensitive(object.get(), name.c_str());
            if (item == nullptr && i >= kFewest && wanted_.empty())
                break;
            if (cJSON_IsNumber(item) == 0)
                bad("has no number \"" + name + "\"");
            values[i] = item->valuedouble;
            if (const char *flaw = flaw_of(values[i], i))
                bad(name + " = " + std::to_string(values[i]) + ": " + flaw);
            at.push_back(i);
        }
        if (objects_ && at.size() != at_.size())
            bad("has other keys than the lines before: sigma in all or none");
        settled_ = objects_ = true;
        at_ = at;
        sample = {values[0], values[1], values[2]};
    }

    void take_names(const std::vector<std::string> &fields) {
        const std::vector<std::string> names =
            wanted_.empty() ? std::vector<std::string>(kNames, kNames + kMost) : wanted_;
        at_.clear();
        for (const std::string &name : names) {
            const auto at = std::find(fields.begin(), fields.end(), name);
            if (at != fields.end())
                at_.push_back(static_cast<size_t>(at - fields.begin()));
            else if (!wanted_.empty() || at_.size() < kFewest)
                hopeless("has no column " + name + " among " + joined(fields) +
                         ": --columns T,Y or T,Y,SIGMA names them");
        }
        width_ = fields.size();
        settled_ = true;
    }

    void take_positions(size_t columns) {
        if (!wanted_.empty())
            hopeless("names no columns: --columns " + joined(wanted_) + " needs a first line that does");
        if (columns < kFewest || columns > kMost)
            bad("has " + std::to_string(columns) + (columns == 1 ? " column" : " columns") + ", separated by " +
                name_of(separator_) + ": without a line of names t,y or t,y,sigma are read");
        at_.clear();
        for (size_t i = 0; i < columns; i++)
            at_.push_back(i);
        width_ = columns;
    }

    double value_of(const std::string &field, size_t column) const {
        double value;
        const bool number = number_of(field, value);
        const char *flaw = number ? flaw_of(value, column) : kNoNumber;
        if (flaw == nullptr)
            return value;
        std::string why = kNames[column] + (" = \"" + field + "\": ") + flaw;
        if (decimal_comma(field))
            why += " with a decimal point, not a decimal comma";
        else if (!number && field.find_first_of(separator_ == Separator::space ? ",;" : ",; \t") != std::string::npos)
            why += std::string("; columns are separated by ") + name_of(separator_);
        bad(why);
    }

    LineSource in_;
    std::vector<std::string> wanted_;
    bool whole_;             // the last line must have its newline
    std::vector<size_t> at_; // places of t, y and sigma in a line
    size_t width_ = 0;       // fields of every line
    size_t number_ = 0;      // of the line
    bool settled_ = false;   // a line of names or a sample has told what lines are like
    bool objects_ = false;   // JSON Lines
    bool cut_ = false;       // the last sample's line has no line end
    Separator separator_ = Separator::comma;
};

SampleReader::SampleReader(const std::string &path, const std::vector<std::string> &columns)
    : lines_(std::make_unique<Lines>(path, columns, false, stop_if_asked)) {}

SampleReader::SampleReader(const std::string &path, const std::vector<std::string> &columns,
                           std::function<void()> awake)
    : lines_(std::make_unique<Lines>(path, columns, true, std::move(awake))) {}

SampleReader::~SampleReader() = default;

bool SampleReader::next(Sample &sample) {
    return lines_->next(sample);
}

const std::string &SampleReader::name() const noexcept {
    return lines_->name();
}

std::string SampleReader::where() const {
    return lines_->where();
}

bool SampleReader::empty() const noexcept {
    return lines_->empty();
}

bool SampleReader::cut() const noexcept {
    return lines_->cut();
}

bool SampleReader::weighted() const noexcept {
    return lines_->weighted();
}

namespace {

// Looks into regular files only: what is read from a pipe is gone.
bool is_npy(const std::string &name) {
    char magic[6] = {};
    struct stat facts = {};
    return ::stat(name.c_str(), &facts) == 0 && S_ISREG(facts.st_mode) &&
           std::ifstream(name, std::ios::binary).read(magic, sizeof magic) &&
           std::memcmp(magic, "\x93NUMPY", sizeof magic) == 0;
}

Series read_npy_series(const std::string &name) {
    InputFile file(name);
    const NpyHeader header = read_npy_header(file);
    if (header.type != "f8" || header.shape.size() != 2 || header.shape[1] < kFewest || header.shape[1] > kMost)
        malformed(name, "must be float64 of shape [samples][2 or 3]: t, y and sigma");
    const size_t rows = header.shape[0], cols = header.shape[1];
    if (rows == 0)
        malformed(name, "holds no samples");
    if (rows > (file.size() - header.size) / (cols * sizeof(double)))
        malformed(name, "is shorter than its header says");
    std::vector<double> numbers(rows * cols);
    if (!file.read(numbers.data(), numbers.size() * sizeof numbers[0]))
        malformed(name, "is shorter than its header says");
    Series series;
    series.name = name;
    for (size_t i = 0; i < rows; i++) {
        const double *row = &numbers[i * cols];
        for (size_t k = 0; k < cols; k++)
            if (!std::isfinite(row[k]) || std::fabs(row[k]) > kLargest || (k == 2 && !(row[k] >= kLeastSigma)))
                malformed(name, "row " + std::to_string(i) + ", " + kNames[k] + " = " + std::to_string(row[k]) +
                                    ": must be finite, within 1e98" + (k == 2 ? " and above 0" : ""));
        series.t.push_back(row[0]);
        series.y.push_back(row[1]);
        if (cols == kMost)
            series.sigma.push_back(row[2]);
    }
    return series;
}

} // namespace

Series read_series(const std::string &name, const std::vector<std::string> &columns) {
    need_series(name);
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
    if (reader.cut())
        series.remark = reader.where() + kCutRemark;
    if (series.t.empty())
        malformed(series.name, reader.empty() ? "is empty" : "holds no samples");
    return series;
}

} // namespace cli
