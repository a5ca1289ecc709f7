#include "series/series_options.hpp"

#include <iterator>

#include "common/content.hpp"

namespace cli {

namespace {

constexpr double kLargest = 1e98; // of the library's columns
constexpr char kBlanks[] = " \t\r\n", kByteOrderMark[] = "\xef\xbb\xbf";

std::string trimmed(const std::string &text) {
    const size_t first = text.find_first_not_of(kBlanks);
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string> fields_of(const std::string &line) {
    std::vector<std::string> fields;
    for (size_t start = 0, end = 0; end != std::string::npos; start = end + 1) {
        end = line.find(',', start);
        fields.push_back(trimmed(line.substr(start, end == std::string::npos ? end : end - start)));
    }
    return fields;
}

class ColumnReader {
  public:
    ColumnReader(const std::string &path, const SampleOptions &samples, toliman_measure *series)
        : source_(path, stop_if_asked), series_(series), name_(name_of(series)), t_(values_of(series, "t")),
          times_(nullptr, options_of_times(info_of(series).time_format, info_of(series).time_scale, samples)) {}

    void read() {
        for (std::string line; source_.next(line);) {
            if (++number_ == 1 && line.compare(0, sizeof kByteOrderMark - 1, kByteOrderMark) == 0)
                line.erase(0, sizeof kByteOrderMark - 1);
            const std::string text = trimmed(line);
            if (text.empty() || text[0] == '#')
                continue;
            if (columns_.empty())
                use_names(fields_of(text));
            else
                add(fields_of(text));
        }
        if (columns_.empty())
            malformed(source_.name(), "has no line with the names of its columns");
        if (rows_ != t_.size())
            malformed(source_.name(),
                      formatted("has %zu rows: must be %zu, one for each sample of ", rows_, t_.size()) + name_);
    }

    const std::vector<std::string> &names() const noexcept { return names_; }

    // To the series.
    void add_columns() {
        number_ = first_;
        for (size_t c = 0; c < names_.size(); c++) {
            const toliman_status status =
                toliman_measure_add_column(series_, names_[c].c_str(), columns_[c].data(), rows_, 0);
            if (status == TOLIMAN_E_ARGUMENT)
                fail(toliman::error(status).detail().substr(std::strlen(" = ")));
            toliman::check(status);
        }
    }

  private:
    [[noreturn]] void fail(const std::string &why) const {
        malformed(source_.name() + ":" + std::to_string(number_), why);
    }

    void use_names(const std::vector<std::string> &fields) {
        double number = 0;
        if (fields.size() < 2 || number_of(fields[0], number))
            fail("must be names of columns separated by commas: t,NAME,...");
        names_.assign(fields.begin() + 1, fields.end());
        for (const std::string &name : names_)
            if (name == "mean" || number_of(name, number) || name.find('=') != std::string::npos)
                fail("\"" + name + "\" is not the name of a column");
        columns_.resize(names_.size());
        first_ = number_;
    }

    void add(const std::vector<std::string> &fields) {
        if (fields.size() != columns_.size() + 1)
            fail(formatted("has %zu columns, the line of names %zu", fields.size(), columns_.size() + 1));
        if (rows_ == t_.size())
            fail(name_ + formatted(" has only %zu samples", t_.size()));
        check_time(fields[0]);
        for (size_t i = 1; i < fields.size(); i++) {
            double value = 0;
            if (!number_of(fields[i], value) || !(std::fabs(value) <= kLargest))
                fail(names_[i - 1] + " = " + fields[i] + ": must be a number in [-1e98, 1e98]");
            columns_[i - 1].push_back(value);
        }
        rows_++;
    }

    void check_time(const std::string &text) {
        Sample sample = {};
        try {
            times_.parse(text + ",0", sample);
        } catch (const BadLine &bad) {
            fail(bad.what());
        }
        if (sample.t != t_[rows_])
            fail(formatted("t = %.17g: must be %.17g, that of sample %zu of ", sample.t, t_[rows_], rows_ + 1) + name_);
    }

    LineSource source_;
    toliman_measure *series_;
    std::string name_;
    std::vector<double> t_;
    SampleParser times_;
    std::vector<std::string> names_;
    std::vector<std::vector<double>> columns_;
    size_t number_ = 0, first_ = 0, rows_ = 0; // lines; that of the names; samples
};

} // namespace

void add_columns(const std::string &path, const SampleOptions &samples, int32_t trend, toliman_measure *series) {
    need(path, "a CSV file of nuisance functions", {Content::text, Content::empty});
    ColumnReader reader(path, samples, series);
    reader.read();
    const size_t columns = static_cast<size_t>(info_of(series).columns) + reader.names().size(),
                 most = kMostFunctions - static_cast<size_t>(trend);
    if (columns > most)
        malformed(name_of(series),
                  formatted("%zu columns of functions and offsets: at most %zu with --trend %d", columns, most, trend));
    reader.add_columns();
}

} // namespace cli
