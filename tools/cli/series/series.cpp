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

void append(Series &series, const Sample &sample) {
    series.t.push_back(sample.t);
    series.y.push_back(sample.y);
    if (sample.sigma > 0)
        series.sigma.push_back(sample.sigma);
}

// The rows pass the parser as text with all digits, so that their values and times have the rules of every series.
Series read_npy_series(const std::string &name, SampleOptions options) {
    InputFile file(name);
    const toliman::NpyHeader header = read_npy_header(file);
    const size_t cols = header.shape.size() == 2 ? header.shape[1] : 0;
    if (header.type != "f8" || cols < 2 || cols > 3)
        malformed(name, "must be a float64 array of shape [samples][2 or 3]: t, y and sigma");
    const size_t rows = header.shape[0];
    if (rows == 0)
        malformed(name, "contains no samples");
    const bool fits = rows <= (file.size() - header.size) / (cols * sizeof(double));
    std::vector<double> numbers(fits ? rows * cols : 0);
    if (!fits || !file.read(numbers.data(), numbers.size() * sizeof numbers[0]))
        malformed(name, "is truncated: it is shorter than its header states");
    options.columns.clear();
    SampleParser parser(nullptr, options);
    Series series;
    series.name = name;
    Sample sample = {};
    parser.parse(cols == 3 ? "t,y,sigma" : "t,y", sample);
    for (size_t i = 0; i < rows; i++) {
        const double *row = &numbers[i * cols];
        try {
            parser.parse(formatted("%.17g,%.17g", row[0], row[1]) + (cols == 3 ? formatted(",%.17g", row[2]) : ""),
                         sample);
        } catch (const BadLine &bad) {
            malformed(name, "row " + std::to_string(i) + ", " + bad.what());
        }
        append(series, sample);
    }
    series.time_scale = parser.time_scale();
    return series;
}

} // namespace

Series read_series(const std::string &name, const SampleOptions &options) {
    need(name, "a series of t, y[, sigma]", // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    if (is_npy(name))
        return read_npy_series(name, options);
    SampleReader reader(name, options);
    Series series;
    series.name = reader.name();
    for (Sample sample = {}; reader.next(sample);)
        append(series, sample);
    series.warning = reader.end(!series.t.empty());
    series.time_scale = reader.time_scale();
    return series;
}

} // namespace cli
