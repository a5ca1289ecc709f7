#include "measure/columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "ingest/fields.hpp"

namespace toliman::measure {

namespace {

constexpr double kLargestInColumn = 1e98; // of Series::add_column

// How to read times as those of the series, from a column of any name.
ingest::SeriesOptions options_of_times(const Series &series, ingest::SeriesOptions options) {
    options.name.clear();
    options.columns.clear();
    options.instrument.clear();
    options.times.plain = !series.dates;
    if (!series.dates)
        return options;
    options.times.format = series.dates->format;
    if (series.dates->scale != ingest::Scale::tai)
        options.times.scale = series.dates->scale;
    return options;
}

class ColumnReader {
  public:
    ColumnReader(const std::string &name, const ingest::SeriesOptions &options, Series &series)
        : name_(name), times_(options_of_times(series, options)), series_(series) {}

    void read(std::string_view line) {
        number_++;
        const std::vector<std::string> fields = ingest::split(line, ',');
        if (fields[0].substr(0, 1) == "#" || (fields.size() == 1 && fields[0].empty()))
            return;
        if (names_.empty())
            use_names(fields);
        else
            add(fields);
    }

    // Adds the columns to the series.
    void end() {
        if (names_.empty())
            toliman::fail(Status::format, "{%s}: has no line with the names of its columns", name_.c_str());
        if (rows_ != series_.count())
            toliman::fail(Status::format, "{%s}: has %zu rows: must be %zu, one for each sample of %s", name_.c_str(),
                          rows_, series_.count(), series_.name.c_str());
        if (series_.columns.size() + names_.size() > kMostFunctions)
            toliman::fail(Status::format, "{%s}: %zu columns of functions and offsets: at most %zu with the trend",
                          series_.name.c_str(), series_.columns.size() + names_.size(), kMostFunctions);
        number_ = first_;
        for (size_t c = 0; c < names_.size(); c++) {
            try {
                series_.add_column(names_[c], std::move(columns_[c]), 0);
            } catch (const Error &error) {
                fail(std::string(error.what()).substr(std::string("name = ").size()));
            }
        }
    }

  private:
    [[noreturn]] void fail(const std::string &why) const {
        toliman::fail(Status::format, "{%s}:%zu: %s", name_.c_str(), number_, why.c_str());
    }

    void use_names(const std::vector<std::string> &fields) {
        double number = 0;
        if (fields.size() < 2 || ingest::number_of(fields[0], number))
            fail("must be names of columns separated by commas: t,NAME,...");
        names_.assign(fields.begin() + 1, fields.end());
        for (const std::string &name : names_)
            if (name == "mean" || ingest::number_of(name, number) || name.find('=') != std::string::npos)
                fail("\"" + name + "\" is not the name of a column");
        columns_.resize(names_.size());
        first_ = number_;
    }

    void add(const std::vector<std::string> &fields) {
        if (fields.size() != columns_.size() + 1)
            fail("has " + std::to_string(fields.size()) + " columns, the line of names " +
                 std::to_string(columns_.size() + 1));
        if (rows_ == series_.count())
            fail(series_.name + " has only " + std::to_string(rows_) + " samples");
        check_time(fields[0]);
        for (size_t c = 0; c < columns_.size(); c++) {
            double value = 0;
            if (!ingest::number_of(fields[c + 1], value) || !(std::fabs(value) <= kLargestInColumn))
                fail(names_[c] + " = " + fields[c + 1] + ": must be a number in [-1e98, 1e98]");
            columns_[c].push_back(value);
        }
        rows_++;
    }

    void check_time(const std::string &text) {
        std::optional<ingest::Sample> sample;
        try {
            sample = times_.parse(text + ",0\n");
        } catch (const Error &error) {
            fail(error.what());
        }
        if (!sample)
            fail("t = " + text + ": must be a time");
        if (sample->t != series_.t[rows_])
            toliman::fail(Status::format, "{%s}:%zu: t = %.17g: must be %.17g, that of sample %zu of %s", name_.c_str(),
                          number_, sample->t, series_.t[rows_], rows_ + 1, series_.name.c_str());
    }

    const std::string &name_;
    ingest::Series times_;
    Series &series_;
    std::vector<std::string> names_;
    std::vector<std::vector<double>> columns_;
    size_t number_ = 0, first_ = 0, rows_ = 0; // lines; that of the names; samples
};

} // namespace

void add_columns(std::string_view bytes, const std::string &name, const ingest::SeriesOptions &options,
                 Series &series) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (bytes.substr(0, 3) == kByteOrderMark)
        bytes.remove_prefix(3);
    ColumnReader reader(name, options, series);
    while (!bytes.empty()) {
        const size_t length = std::min(bytes.find('\n'), bytes.size());
        reader.read(bytes.substr(0, length));
        bytes.remove_prefix(std::min(length + 1, bytes.size()));
    }
    reader.end();
}

} // namespace toliman::measure
