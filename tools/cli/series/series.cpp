#include "series/series.hpp"

#include <CLI/App.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "common/content.hpp"
#include "common/input.hpp"
#include "common/npy.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "scenes/leap_seconds.hpp"

namespace cli {

namespace {

constexpr double kFirstJulianDay = 2e6;
const std::map<std::string, int32_t> kFormats = {{"", 0},
                                                 {"days", 0},
                                                 {"iso", TOLIMAN_INGEST_FORMAT_ISO},
                                                 {"mjd", TOLIMAN_INGEST_FORMAT_MJD},
                                                 {"jd", TOLIMAN_INGEST_FORMAT_JD}};
const std::map<std::string, int32_t> kScales = {{"", 0},
                                                {"utc", TOLIMAN_INGEST_SCALE_UTC},
                                                {"tai", TOLIMAN_INGEST_SCALE_TAI},
                                                {"tt", TOLIMAN_INGEST_SCALE_TT},
                                                {"tdb", TOLIMAN_INGEST_SCALE_TDB},
                                                {"gps", TOLIMAN_INGEST_SCALE_GPS}};

} // namespace

void add_times(CLI::App &command, SampleOptions &options) {
    command
        .add_option("--time-format", options.time_format,
                    "times are dates (iso), Modified Julian Days (mjd), Julian Days (jd) or plain numbers (days); "
                    "default: from the first time and the column's name")
        ->check(CLI::IsMember({"days", "iso", "jd", "mjd"}));
    command
        .add_option("--time-scale", options.time_scale,
                    "time scale of dates, mjd and jd: utc (default), tai, tt, tdb or gps; utc becomes TAI")
        ->check(CLI::IsMember({"utc", "tai", "tt", "tdb", "gps"}));
}

std::string result_scale(const std::string &scale) {
    std::string result = scale.empty() || scale == "utc" ? "tai" : scale;
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
    return result;
}

std::string name_of_scale(int32_t scale) {
    for (const auto &[name, known] : kScales)
        if (known == scale && !name.empty())
            return result_scale(name);
    return "";
}

SampleParser::SampleParser(const char *name, const SampleOptions &options, uint32_t flags)
    : name_(name != nullptr ? name : ""), options_(options) {
    auto how = toliman::sized<toliman_series_options>();
    how.flags = flags | (options.time_format == "days" ? TOLIMAN_SERIES_PLAIN_TIMES : 0);
    how.time_format = kFormats.at(options.time_format);
    how.time_scale = kScales.at(options.time_scale);
    how.name = name;
    const LeapSeconds table(options.leap_seconds);
    how.leap_seconds = table.rows.data();
    how.leap_second_count = table.rows.size();
    how.columns = options.columns.empty() ? nullptr : options.columns.c_str();
    try {
        parser_ = toliman::make<toliman::series_parser>(toliman_series_create, &how);
    } catch (const toliman::error &error) {
        if (error.field() != "options->columns")
            throw;
        throw Failure(kExitUsage, "--columns " + options.columns + ": must be T,Y or T,Y,SIGMA");
    }
}

bool SampleParser::parse(const std::string &line, Sample &sample) {
    sample = toliman::sized<Sample>();
    const toliman_status status = toliman_series_parse(parser_.get(), line.data(), line.size(), &sample);
    if (status != TOLIMAN_OK)
        fail(status);
    if (sample.found != 0 && !checked_)
        check_times();
    return sample.found != 0;
}

// Adds the option that would admit the line.
void SampleParser::fail(toliman_status status) const {
    const toliman::error error(status);
    const int32_t format = info().time_format;
    const bool by_name = options_.time_format.empty() && format != 0 && format != TOLIMAN_INGEST_FORMAT_ISO;
    if (status == TOLIMAN_E_FORMAT)
        throw BadLine(error.what() +
                      std::string(by_name && error.field() == "t" ? "; --time-format days reads plain numbers" : ""));
    if (status != TOLIMAN_E_MISMATCH)
        throw error;
    const std::string hint = error.field() == name_ ? " (--columns " + options_.columns + ")"
                                                    : ": name the columns with --columns T,Y or T,Y,SIGMA";
    throw Failure(kExitInput, error.what() + hint);
}

void SampleParser::check_times() {
    const bool plain = info().time_format == 0;
    if (plain && !options_.time_scale.empty())
        throw Failure(kExitUsage,
                      "--time-scale " + options_.time_scale +
                          ": the times are plain numbers: give --time-format mjd or jd if they are such days");
    if (!plain && options_.of_state && options_.time_scale.empty())
        throw Failure(kExitUsage, "--from-state: sums contain no time scale: give that of these times by --time-scale");
    checked_ = true;
}

std::string SampleParser::time_scale() const {
    return info().time_format == 0 ? "" : result_scale(options_.time_scale);
}

SampleReader::SampleReader(const std::string &path, const SampleOptions &options, const std::function<void()> &on_idle)
    : in_(path, on_idle ? on_idle : stop_if_asked),
      parser_(in_.name().c_str(), options, on_idle ? TOLIMAN_SERIES_GROWING : 0) {}

bool SampleReader::next(Sample &sample) {
    for (std::string line; in_.next(line);) {
        if (line.compare(0, 6, "\x93NUMPY") == 0)
            malformed(name(), "is a .npy file: give its name, without --follow and --from-state");
        if (line.compare(0, 4, "TLMP") == 0)
            malformed(name(), "is a saved state: give it to --from-state");
        if (in_.whole())
            line += '\n';
        if (parser_.parse(line, sample))
            return true;
    }
    return false;
}

std::string SampleReader::end(bool samples) const {
    const toliman_series_info info = parser_.info();
    if (!samples)
        malformed(name(), info.lines == 0 ? "is empty" : "contains no samples");
    return info.truncated == 0 ? "" : where() + ": has no newline at its end; its last number may be truncated";
}

namespace {

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
    series.time_format = parser.info().time_format;
    return series;
}

} // namespace

double time_of(const std::string &option, const std::string &text, const SampleOptions &options, bool plain) {
    double number = 0;
    const bool is_number = number_of(text, number);
    if (plain && !(is_number && std::isfinite(number)))
        throw Failure(kExitUsage, option + " " + text + ": must be a finite number, as the times of the series are");
    if (plain)
        return number;
    SampleOptions how = options;
    how.columns.clear();
    how.time_format = !is_number ? "iso" : number < kFirstJulianDay ? "mjd" : "jd";
    SampleParser parser(nullptr, how);
    Sample sample = {};
    try {
        parser.parse(text + ",0", sample);
    } catch (const BadLine &bad) {
        throw Failure(kExitUsage, option + " " + text +
                                      ": must be a date, a Modified Julian Day or a Julian Day, as "
                                      "the times of the series are: " +
                                      bad.what());
    }
    return sample.t;
}

SampleOptions options_of_times(const Series &series, const SampleOptions &options) {
    SampleOptions how = options;
    how.columns.clear();
    for (const auto &[name, format] : kFormats)
        if (format == series.time_format && !name.empty())
            how.time_format = name;
    return how;
}

std::vector<int64_t> tai_of(const Series &series) {
    if (series.time_scale.empty())
        malformed(series.name, "times are plain numbers: must be dates, Modified Julian Days or Julian Days "
                               "(--time-format mjd or jd)");
    std::string scale = series.time_scale;
    std::transform(scale.begin(), scale.end(), scale.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    std::vector<int64_t> times;
    for (const double t : series.t) {
        times.emplace_back();
        toliman::check(toliman_ingest_parse_time(formatted("%.17g", t).c_str(), TOLIMAN_INGEST_FORMAT_MJD,
                                                 kScales.at(scale), nullptr, 0, &times.back()));
    }
    return times;
}

Series read_series(const std::string &name, const SampleOptions &options) {
    const SampleParser options_are_valid(nullptr, options); // an error before the file is opened
    need(name, "a series of t, y[, sigma]",                 // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    if (identify(name).content == Content::npy)
        return read_npy_series(name, options);
    SampleReader reader(name, options);
    Series series;
    series.name = reader.name();
    for (Sample sample = {}; reader.next(sample);)
        append(series, sample);
    series.warning = reader.end(!series.t.empty());
    series.time_scale = reader.time_scale();
    series.time_format = reader.time_format();
    return series;
}

} // namespace cli
