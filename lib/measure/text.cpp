// Method: every number passes the parser of lines, also those of a .npy table, as text with all digits: values and
// times then have the same rules in every format.
#include "measure/text.hpp"

#include <cstring>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "frame/npy.hpp"

namespace toliman::measure {

namespace {

constexpr char kNpy[] = "\x93NUMPY";

class Reader {
  public:
    explicit Reader(const ingest::SeriesOptions &options) : parser_(options) {}

    void read(std::string_view line) {
        const std::optional<ingest::Sample> sample = parser_.parse(line);
        if (!sample)
            return;
        series_.t.push_back(sample->t);
        series_.y.push_back(sample->y);
        if (sample->sigma > 0)
            series_.sigma.push_back(sample->sigma);
    }

    // name: "" for messages without one.
    Text end(const std::string &name) {
        if (series_.t.empty())
            fail(Status::format, "{%s}: contains no samples", name.empty() ? "series" : name.c_str());
        if (const std::optional<ingest::TimeFormat> format = parser_.format())
            series_.dates = Dates{*format, parser_.scale()};
        Text text = {std::move(series_), ""};
        if (parser_.truncated())
            text.warning = (name.empty() ? "series" : name) + ":" + std::to_string(parser_.lines()) +
                           ": has no newline at its end; its last number may be truncated";
        return text;
    }

  private:
    ingest::Series parser_;
    Series series_;
};

Text read_lines(std::string_view bytes, const ingest::SeriesOptions &options) {
    Reader reader(options);
    while (!bytes.empty()) {
        const size_t newline = bytes.find('\n');
        const size_t length = newline == std::string_view::npos ? bytes.size() : newline + 1;
        reader.read(bytes.substr(0, length));
        bytes.remove_prefix(length);
    }
    return reader.end(options.name);
}

Text read_table(std::string_view bytes, ingest::SeriesOptions options) {
    const std::string name = options.name.empty() ? "series" : options.name;
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
    Reader reader(options);
    reader.read(cols == 3 ? "t,y,sigma\n" : "t,y\n");
    for (size_t i = 0; i < rows; i++) {
        double row[3];
        next(row, cols * sizeof *row);
        char line[100];
        const size_t size = cols == 3 ? print_text(line, sizeof line, "%.17g,%.17g,%.17g\n", row[0], row[1], row[2])
                                      : print_text(line, sizeof line, "%.17g,%.17g\n", row[0], row[1]);
        try {
            reader.read({line, size});
        } catch (const Error &error) {
            fail_within(error, error.status(), "{%s}: row %zu, %s", name.c_str(), i, error.what());
        }
    }
    return reader.end(name);
}

} // namespace

Text read_text(std::string_view bytes, const ingest::SeriesOptions &options) {
    Text text = bytes.substr(0, sizeof kNpy - 1) == kNpy ? read_table(bytes, options) : read_lines(bytes, options);
    text.series.name = options.name;
    return text;
}

} // namespace toliman::measure
