#include "series/series.hpp"

#include <cstring>
#include <fstream>
#include <sys/stat.h>

#include "common/content.hpp"
#include "common/input.hpp"
#include "common/npy.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

// Regular files only: bytes that are read from a pipe cannot be read again.
bool is_npy(const std::string &name) {
    char magic[6] = {};
    struct stat status = {};
    return ::stat(name.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
           std::ifstream(name, std::ios::binary).read(magic, sizeof magic) &&
           std::memcmp(magic, "\x93NUMPY", sizeof magic) == 0;
}

double day_of(const Times &times, double number, const std::string &name, size_t row) {
    try {
        return times.day_of(formatted("%.17g", number));
    } catch (const Failure &failure) {
        malformed(name, "row " + std::to_string(row) + ", t: " + failure.what());
    }
}

Series read_npy_series(const std::string &name, const TimeOptions &options) {
    InputFile file(name);
    const toliman::NpyHeader header = read_npy_header(file);
    if (header.type != "f8" || header.shape.size() != 2 || header.shape[1] < kFewestColumns ||
        header.shape[1] > kMostColumns)
        malformed(name, "must be a float64 array of shape [samples][2 or 3]: t, y and sigma");
    const size_t rows = header.shape[0], cols = header.shape[1];
    if (rows == 0)
        malformed(name, "contains no samples");
    const bool fits = rows <= (file.size() - header.size) / (cols * sizeof(double));
    std::vector<double> numbers(fits ? rows * cols : 0);
    if (!fits || !file.read(numbers.data(), numbers.size() * sizeof numbers[0]))
        malformed(name, "is truncated: it is shorter than its header states");
    Times times(options);
    times.begin("", "");
    Series series;
    series.name = name;
    series.time_scale = times.scale();
    for (size_t i = 0; i < rows; i++) {
        const double *row = &numbers[i * cols];
        for (size_t k = 0; k < cols; k++)
            if (const char *flaw = flaw_of(row[k], k))
                malformed(name, "row " + std::to_string(i) + ", " + kSampleNames[k] + " = " + std::to_string(row[k]) +
                                    ": " + flaw);
        series.t.push_back(times.plain() ? row[0] : day_of(times, row[0], name, i));
        series.y.push_back(row[1]);
        if (cols == kMostColumns)
            series.sigma.push_back(row[2]);
    }
    return series;
}

} // namespace

Series read_series(const std::string &name, const std::vector<std::string> &columns, const TimeOptions &times) {
    need(name, "a series of t, y[, sigma]", // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    if (is_npy(name))
        return read_npy_series(name, times);
    SampleReader reader(name, columns, times);
    Series series;
    series.name = reader.name();
    for (Sample sample = {}; reader.next(sample);) {
        series.t.push_back(sample.t);
        series.y.push_back(sample.y);
        if (reader.weighted())
            series.sigma.push_back(sample.sigma);
    }
    series.time_scale = reader.time_scale();
    if (reader.truncated())
        series.warning = reader.where() + kTruncatedWarning;
    if (series.t.empty())
        malformed(series.name, reader.empty() ? "is empty" : "contains no samples");
    return series;
}

} // namespace cli
