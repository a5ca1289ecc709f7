// Reads time series with the library: whole files, or line by line where input grows or continues sums.
#pragma once
#include "common/lines.hpp"

namespace cli {

using Sample = toliman_series_sample;

// Options of the command line; empty: the defaults of series.h.
struct SampleOptions {
    std::string columns, time_format, time_scale; // of --columns, --time-format and --time-scale
    std::string instrument = {};                  // of --instrument: the column that names it
    std::string functions = {};                   // of --nuisance-file; of whole series
    std::string leap_seconds = {}; // path of a leap-seconds.list for times in UTC; empty: the table of the library
    bool of_state = false;         // the samples continue sums, whose time scale is unknown: time_scale must be given

    void add_to(CLI::App &command, bool with_instrument);
};

// Reads the value of an option, a time in the format of a series that was read by `options`: a number if its times
// are, otherwise a date, a Modified Julian Day or a Julian Day. Returns it as t of a sample.
double time_of(const std::string &option, const std::string &text, const SampleOptions &options, int32_t time_format,
               int32_t time_scale);

// How to read times as those of the series, which was read by `options`, from a column of any name.
SampleOptions options_of_times(int32_t time_format, int32_t time_scale, const SampleOptions &options);

// "TAI", of a TOLIMAN_INGEST_SCALE_...; "" for 0, plain numbers.
std::string name_of_scale(int32_t scale);

// The scale of the resulting times: TAI for UTC, otherwise the same scale.
std::string result_scale(const std::string &scale);

// A line that is not a sample; later lines may be.
class BadLine : public Failure {
  public:
    explicit BadLine(const std::string &text) : Failure(kExitInput, text) {}
};

class SampleParser {
  public:
    // name: of the input in messages, which begin with name:line; nullptr: without
    SampleParser(const char *name, const SampleOptions &options, uint32_t flags = 0);
    // False for a comment, an empty line or the line of names. BadLine for a malformed line.
    bool parse(const std::string &line, Sample &sample);
    toliman_series_info info() const {
        return toliman::result<toliman_series_info>(toliman_series_get_info, parser_.get());
    }
    std::string time_scale() const; // of Modified Julian Days; empty for plain numbers
    std::vector<std::string> take_warnings() { return std::exchange(*warnings_, {}); }

  private:
    std::string name_; // of the input; the field of an error that is not about one column
    SampleOptions options_;
    std::unique_ptr<std::vector<std::string>> warnings_; // at an address that the library knows
    toliman::series_parser parser_;
    bool checked_ = false; // the options suit the times
};

class SampleReader {
  public:
    // path: a file, or - for standard input. on_idle, as in LineSource, is for input that another process is still
    // writing: a last line without newline may be truncated and is a BadLine.
    SampleReader(const std::string &path, const SampleOptions &options, const std::function<void()> &on_idle = nullptr);

    // False at the end.
    bool next(Sample &sample);
    const std::string &name() const noexcept { return in_.name(); } // the file's name in messages
    std::string where() const { return name() + ":" + std::to_string(parser_.info().lines); } // the last line's
    toliman_series_info info() const { return parser_.info(); }
    std::string time_scale() const { return parser_.time_scale(); }
    std::vector<std::string> take_warnings() { return parser_.take_warnings(); }
    // The warnings about the whole input. Failure if there were no samples.
    std::vector<std::string> end(bool samples);

  private:
    LineSource in_;
    SampleParser parser_;
};

// The numbers of the samples of a series.
struct Samples {
    explicit Samples(const toliman_measure *series)
        : t(values_of(series, "t")), y(values_of(series, "y")), sigma(values_of(series, "sigma")) {}

    size_t count() const noexcept { return t.size(); }
    const double *sigmas() const noexcept { return sigma.empty() ? nullptr : sigma.data(); }
    std::vector<Column> columns() const; // t, y and, if there is one, sigma

    std::vector<double> t, y, sigma; // sigma: empty if it is not known
};

// All samples of a file of any format of measure.h, or of standard input: at least one; times with a unit in days.
toliman::measurements read_series(const std::string &name, const SampleOptions &options, Progress &progress);
// A series of arrays; name: of their source.
toliman::measurements series_of(const std::string &name, const std::vector<double> &t, const std::vector<double> &y);

} // namespace cli
