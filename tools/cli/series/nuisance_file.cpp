#include "series/series_options.hpp"

#include <iterator>

#include "common/content.hpp"

namespace cli {

namespace {

constexpr double kLargest = 1e98;
constexpr size_t kLongestName = 63;
const std::string kReserved[] = {
    "t", "y", "sigma", "position_angle_deg", "separation_arcsec", "factor", "geometric_arcsec"}; // measure.h
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
    ColumnReader(const std::string &path, const Series &series, const SampleOptions &samples)
        : source_(path, stop_if_asked), series_(series), times_(nullptr, options_of_times(series, samples)) {}

    std::vector<NuisanceColumn> read() {
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
        if (rows_ != series_.t.size())
            malformed(source_.name(),
                      formatted("has %zu rows: must be %zu, one for each sample of ", rows_, series_.t.size()) +
                          series_.name);
        return columns_;
    }

  private:
    [[noreturn]] void fail(const std::string &why) const {
        malformed(source_.name() + ":" + std::to_string(number_), why);
    }

    void use_names(const std::vector<std::string> &fields) {
        double number = 0;
        const std::vector<std::string> polynomials = names_of_trend(kMostTrend);
        if (fields.size() < 2 || number_of(fields[0], number))
            fail("must be names of columns separated by commas: t,NAME,...");
        for (size_t i = 1; i < fields.size(); i++) {
            const std::string &name = fields[i];
            if (name.empty() || name.size() > kLongestName || number_of(name, number) ||
                name.find('=') != std::string::npos)
                fail("\"" + name + "\" is not the name of a column");
            if (std::find(std::begin(kReserved), std::end(kReserved), name) != std::end(kReserved))
                fail("\"" + name + "\" is a name of the series itself: must be another");
            if (std::count(polynomials.begin(), polynomials.end(), name) > 0)
                fail("\"" + name + "\" is the name of a function of --trend");
            if (std::count(fields.begin() + 1, fields.end(), name) > 1)
                fail("two columns have the name \"" + name + "\"");
            columns_.push_back({name, {}});
        }
    }

    void add(const std::vector<std::string> &fields) {
        if (fields.size() != columns_.size() + 1)
            fail(formatted("has %zu columns, the line of names %zu", fields.size(), columns_.size() + 1));
        if (rows_ == series_.t.size())
            fail(series_.name + formatted(" has only %zu samples", series_.t.size()));
        check_time(fields[0]);
        for (size_t i = 1; i < fields.size(); i++) {
            double value = 0;
            if (!number_of(fields[i], value) || !(std::fabs(value) <= kLargest))
                fail(columns_[i - 1].name + " = " + fields[i] + ": must be a number in [-1e98, 1e98]");
            columns_[i - 1].values.push_back(value);
            columns_[i - 1].bound = std::max(columns_[i - 1].bound, std::fabs(value));
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
        if (sample.t != series_.t[rows_])
            fail(formatted("t = %.17g: must be %.17g, that of sample %zu of ", sample.t, series_.t[rows_], rows_ + 1) +
                 series_.name);
    }

    LineSource source_;
    const Series &series_;
    SampleParser times_;
    std::vector<NuisanceColumn> columns_;
    size_t number_ = 0, rows_ = 0; // lines; samples
};

} // namespace

std::vector<NuisanceColumn> read_columns(const std::string &path, const Series &series, const SampleOptions &samples) {
    need(path, "a CSV file of nuisance functions", {Content::text, Content::empty});
    std::vector<NuisanceColumn> columns = ColumnReader(path, series, samples).read();
    for (NuisanceColumn &column : columns) // the library's least bound; 0 would be its default
        column.bound = std::max(column.bound, 1 / kLargest);
    return columns;
}

} // namespace cli
