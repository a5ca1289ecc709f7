// Method: every number passes the parser of lines, also those of a .npy table, as text with all digits: values and
// times then have the same rules in every format.
#include "measure/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "frame/npy.hpp"
#include "ingest/series_values.hpp"

namespace toliman::measure {

namespace {

constexpr char kNpy[] = "\x93NUMPY", kBlanks[] = " \t\r\n";

class Reader {
  public:
    // what: the word for a line in messages; before: lines before the first one that is counted.
    Reader(const ingest::SeriesOptions &options, std::string name, std::string what = "line", int64_t before = 0)
        : parser_(options), has_instruments_(!options.instrument.empty()),
          name_(name.empty() ? "series" : std::move(name)), what_(std::move(what)), before_(before) {}

    void read(std::string_view line) {
        const std::optional<ingest::Sample> sample = parser_.parse(line);
        if (!sample)
            return;
        series_.t.push_back(sample->t);
        series_.y.push_back(sample->y);
        if (sample->sigma > 0)
            series_.sigma.push_back(sample->sigma);
        if (!has_instruments_)
            return;
        if (sample->instrument < 0)
            fail(Status::format, "{%s}: %s %lld: has no instrument", name_.c_str(), what_.c_str(),
                 static_cast<long long>(parser_.lines() - before_));
        of_samples_.push_back(static_cast<int32_t>(sample->instrument));
    }

    Text end() {
        const auto samples = static_cast<int64_t>(series_.t.size()), missing = parser_.missing();
        const std::string rows = std::to_string(missing) + " of " + std::to_string(samples + missing) +
                                 " rows have no value" + (missing == samples + missing ? " of t, y or sigma" : "");
        if (samples == 0)
            fail(Status::format, "{%s}: contains no samples%s", name_.c_str(),
                 missing > 0 ? (": " + rows).c_str() : "");
        if (const std::string mark = parser_.marks().found(what_, before_); !mark.empty())
            fail(Status::format,
                 "{%s}: %s: far from all others, as if it stood for a missing value: remove it or leave it empty",
                 name_.c_str(), mark.c_str());
        if (const std::optional<ingest::TimeFormat> format = parser_.format())
            series_.dates = Dates{*format, parser_.scale()};
        series_.time_unit_days = parser_.time_unit_days() > 0 ? parser_.time_unit_days() : 1;
        series_.left_out = static_cast<size_t>(missing);
        if (!of_samples_.empty())
            series_.set_instruments(parser_.instruments(), std::move(of_samples_));
        Text text = {std::move(series_), parser_.unit(), parser_.take_warnings()};
        if (missing > 0)
            text.warnings.push_back(name_ + ": " + rows + " and are skipped");
        if (const std::string column = parser_.likely_instrument(); !column.empty())
            text.warnings.push_back(
                name_ + ": column " + column +
                " seems to name several instruments: without the option instrument, the series is read as that of one");
        if (parser_.truncated())
            text.warnings.push_back(name_ + ":" + std::to_string(parser_.lines()) +
                                    ": has no newline at its end; its last number may be truncated");
        return text;
    }

  private:
    ingest::Series parser_;
    bool has_instruments_;
    std::string name_, what_;
    int64_t before_;
    Series series_;
    std::vector<int32_t> of_samples_; // instruments
};

Text read_lines(std::string_view bytes, const ingest::SeriesOptions &options) {
    Reader reader(options, options.name);
    while (!bytes.empty()) {
        const size_t newline = bytes.find('\n');
        const size_t length = newline == std::string_view::npos ? bytes.size() : newline + 1;
        reader.read(bytes.substr(0, length));
        bytes.remove_prefix(length);
    }
    return reader.end();
}

// The end of the JSON object at the beginning, behind its brace; npos if it has none.
size_t object_end(std::string_view text) noexcept {
    int depth = 0;
    bool quoted = false;
    for (size_t at = 0; at < text.size(); at++) {
        if (quoted && text[at] == '\\')
            at++;
        else if (text[at] == '"')
            quoted = !quoted;
        else if (!quoted && (text[at] == '{' || text[at] == '}'))
            depth += text[at] == '{' ? 1 : -1;
        if (depth == 0)
            return at + 1;
    }
    return text.npos;
}

// An array of objects; each is parsed as a line.
Text read_array(std::string_view bytes, ingest::SeriesOptions options) {
    const std::string name = options.name.empty() ? "series" : options.name;
    const auto skip = [&](size_t size) {
        bytes.remove_prefix(std::min(size, bytes.size()));
        bytes.remove_prefix(std::min(bytes.find_first_not_of(kBlanks), bytes.size()));
    };
    options.name.clear();
    Reader reader(options, name, "object");
    skip(bytes.find('[') + 1);
    for (size_t object = 1; bytes.substr(0, 1) == "{"; object++) {
        const size_t end = object_end(bytes);
        try {
            reader.read(bytes.substr(0, end));
        } catch (const Error &error) {
            fail_within(error, error.status(), "{%s}: object %zu: %s", name.c_str(), object, error.what());
        }
        skip(end);
        if (bytes.substr(0, 1) != ",")
            break;
        skip(1);
    }
    if (bytes.substr(0, 1) != "]" || bytes.find_first_not_of(kBlanks, 1) != bytes.npos)
        fail(Status::format, "{%s}: is not a JSON array of objects", name.c_str());
    return reader.end();
}

Text read_table(std::string_view bytes, ingest::SeriesOptions options) {
    const std::string name = options.name.empty() ? "series" : options.name;
    constexpr int64_t kBefore = 2; // the line of names; rows count from 0
    size_t at = 0;
    const auto next = [&](void *data, size_t size) {
        if (size > bytes.size() - at)
            return false;
        std::memcpy(data, bytes.data() + at, size);
        at += size;
        return true;
    };
    NpyHeader header;
    if (const std::string why = read_npy_header(next, header); !why.empty())
        fail(Status::format, "{%s}: %s", name.c_str(), why.c_str());
    const size_t cols = header.shape.size() == 2 ? header.shape[1] : 0;
    if (header.type != "f8" || cols < 2 || cols > 3)
        fail(Status::format, "{%s}: must be a float64 array of shape [samples][2 or 3]: t, y and sigma", name.c_str());
    const size_t rows = header.shape[0];
    if (rows > (bytes.size() - at) / (cols * sizeof(double)))
        fail(Status::format, "{%s}: is truncated: it is shorter than its header states", name.c_str());
    if (!options.columns.empty())
        fail(Status::argument, "{options->columns}: must be NULL for a .npy table, whose columns have no names");
    options.name.clear();
    Reader reader(options, name, "row", kBefore);
    reader.read(cols == 3 ? "t,y,sigma\n" : "t,y\n");
    for (size_t i = 0; i < rows; i++) {
        double row[3];
        next(row, cols * sizeof *row);
        char line[100];
        for (size_t k = 0; k < cols; k++)
            if (!std::isfinite(row[k]))
                fail(Status::format, "{%s}: row %zu, %s = \"%g\": must be a finite number", name.c_str(), i,
                     ingest::kSeriesColumns[k], row[k]);
        const size_t size = cols == 3 ? print_text(line, sizeof line, "%.17g,%.17g,%.17g\n", row[0], row[1], row[2])
                                      : print_text(line, sizeof line, "%.17g,%.17g\n", row[0], row[1]);
        try {
            reader.read({line, size});
        } catch (const Error &error) {
            fail_within(error, error.status(), "{%s}: row %zu, %s", name.c_str(), i, error.what());
        }
    }
    return reader.end();
}

// Refuses what begins like a file of another format, as a message of its first line would not name it.
void check_format(std::string_view bytes, const std::string &name) {
    static constexpr std::pair<std::string_view, const char *> kOthers[] = {
        {"<", "XML or HTML"},
        {"\\begin", "LaTeX"},
        {"\\documentclass", "LaTeX"},
        {"\xff\xfe", "UTF-16"},
        {"\xfe\xff", "UTF-16"},
        {"\x1f\x8b", "a gzip file"},
        {"BZh", "a bzip2 file"},
        {"\xfd\x37zXZ", "an xz file"},
        {"\x28\xb5\x2f\xfd", "a Zstandard file"},
        {"PK\x03\x04", "a zip file or workbook"},
        {"SIMPLE  =", "a FITS file"},
        {"\x89HDF", "an HDF5 file"},
        {"%PDF", "a PDF file"},
    };
    for (const auto &[magic, format] : kOthers)
        if (bytes.substr(0, magic.size()) == magic)
            fail(Status::format, "{%s}: is %s: must be a table in text, such as CSV or ECSV", name.c_str(), format);
    if (bytes.find('\r') != bytes.npos && bytes.find('\n') == bytes.npos)
        fail(Status::format, "{%s}: has lines that end with CR: must end with LF", name.c_str());
}

} // namespace

Text read_text(std::string_view bytes, const ingest::SeriesOptions &options) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    const size_t first = bytes.substr(0, 3) == kByteOrderMark ? 3 : 0;
    const size_t begin = bytes.find_first_not_of(kBlanks, first), next = bytes.find_first_not_of(kBlanks, begin + 1);
    const bool is_array =
        begin != bytes.npos && bytes[begin] == '[' && next != bytes.npos && (bytes[next] == '{' || bytes[next] == ']');
    check_format(bytes.substr(std::min(begin, bytes.size())), options.name.empty() ? "series" : options.name);
    Text text = bytes.substr(0, sizeof kNpy - 1) == kNpy ? read_table(bytes, options)
                : is_array                               ? read_array(bytes.substr(begin), options)
                                                         : read_lines(bytes, options);
    text.series.name = options.name;
    return text;
}

void set_unit(std::optional<Kind> kind, double unit, Text &text) {
    using ingest::Quantity;
    const ingest::Unit &stated = text.unit;
    Series &series = text.series;
    const char *const name = stated.name.c_str(), *const source = series.name.c_str();
    const bool is_velocity = stated.quantity == Quantity::velocity, is_angle = stated.quantity == Quantity::angle;
    series.unit_name = stated.name;
    series.kind = kind.value_or(is_velocity ? Kind::velocity : Kind::value);
    const bool of_velocity = series.kind == Kind::velocity, of_value = series.kind == Kind::value;
    if ((is_velocity && !of_velocity && !of_value) || (is_angle && of_velocity))
        fail(Status::argument, "{options->kind}: y is in %s, as %s states", name, source);
    if (stated.quantity == Quantity::pixels && !of_value && unit == 0)
        fail(Status::argument, "{options->unit} = 0: y is in px, as %s states: must be arcsec per px", source);
    const double known = is_angle || (is_velocity && of_velocity) ? stated.factor : 0;
    if (unit > 0 && known > 0 && !(std::fabs(unit / known - 1) < 1e-9))
        fail(Status::argument, "{options->unit} = %g: must be %g or 0: y is in %s, as %s states", unit, known, name,
             source);
    series.unit = unit == 0 && known > 0 ? known : known_unit(unit, series.kind);
}

} // namespace toliman::measure
