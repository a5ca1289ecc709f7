#include "series/series.hpp"

#include <CLI/App.hpp>
#include <cctype>

#include "common/content.hpp"
#include "options/command.hpp"
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

void collect(int32_t, const char *text, void *warnings) {
    static_cast<std::vector<std::string> *>(warnings)->emplace_back(text);
}

// Adds the option that would admit the line. name: of the input.
[[noreturn]] void refuse(const toliman::error &error, const std::string &name, const SampleOptions &options) {
    if (error.status() == TOLIMAN_E_FORMAT)
        throw BadLine(error.what() + std::string(options.time_format.empty() && error.field() == "t"
                                                     ? "; --time-format days, iso, jd or mjd states another format"
                                                     : ""));
    if (error.status() != TOLIMAN_E_MISMATCH)
        throw error;
    throw Failure(kExitInput,
                  error.what() + (error.field() == name ? " (--columns " + options.columns + ")"
                                                        : ": name the columns with --columns T,Y or T,Y,SIGMA"));
}

// The options of a parser, or of a whole series, whose members have the same names.
template <class How> void set_options(const SampleOptions &options, const LeapSeconds &table, How &how) {
    how.flags = options.time_format == "days" ? TOLIMAN_SERIES_PLAIN_TIMES : 0;
    how.time_format = kFormats.at(options.time_format);
    how.time_scale = kScales.at(options.time_scale);
    how.leap_seconds = table.rows.data();
    how.leap_second_count = table.rows.size();
    how.columns = options.columns.empty() ? nullptr : options.columns.c_str();
    how.instrument = options.instrument.empty() ? nullptr : options.instrument.c_str();
}

void check_times(const SampleOptions &options, int32_t time_format) {
    if (time_format == 0 && !options.time_scale.empty())
        throw Failure(kExitUsage,
                      "--time-scale " + options.time_scale +
                          ": the times are plain numbers: give --time-format mjd or jd if they are such days");
    if (time_format != 0 && options.of_state && options.time_scale.empty())
        throw Failure(kExitUsage, "--from-state: sums contain no time scale: give that of these times by --time-scale");
}

// Refuses by the first line what is not a series.
void check_start(const std::string &name, const std::string &line) {
    if (line.compare(0, 6, "\x93NUMPY") == 0)
        malformed(name, "is a .npy file: give its name, without --follow and --from-state");
    if (line.compare(0, 4, "TLMP") == 0)
        malformed(name, "is a saved state: give it to --from-state");
}

// All bytes of standard input or of a pipe; a signal ends the wait.
std::string text_of(LineSource &source) {
    std::string text;
    for (std::string line; source.next(line);) {
        if (text.empty())
            check_start(source.name(), line);
        text += line;
        if (source.whole())
            text += '\n';
    }
    return text;
}

} // namespace

void SampleOptions::add_to(CLI::App &command, bool with_instrument) {
    add_option(&command, "--columns", columns, "NAMES");
    command.add_option("--time-format", time_format)->check(CLI::IsMember({"days", "iso", "jd", "mjd"}));
    command.add_option("--time-scale", time_scale)->check(CLI::IsMember({"utc", "tai", "tt", "tdb", "gps"}));
    if (with_instrument)
        add_option(&command, "--instrument", instrument, "COLUMN");
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
    : name_(name != nullptr ? name : ""), options_(options), warnings_(new std::vector<std::string>) {
    auto how = toliman::sized<toliman_series_options>();
    const LeapSeconds table(options.leap_seconds);
    set_options(options, table, how);
    how.flags |= flags;
    how.name = name;
    how.log = collect;
    how.log_data = warnings_.get();
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
        refuse(toliman::error(status), name_, options_);
    if (sample.found != 0 && !checked_)
        check_times(options_, info().time_format);
    checked_ = checked_ || sample.found != 0;
    return sample.found != 0;
}

std::string SampleParser::time_scale() const {
    return name_of_scale(info().time_scale);
}

SampleReader::SampleReader(const std::string &path, const SampleOptions &options, const std::function<void()> &on_idle)
    : in_(path, on_idle ? on_idle : stop_if_asked),
      parser_(in_.name().c_str(), options, on_idle ? TOLIMAN_SERIES_GROWING : 0) {}

bool SampleReader::next(Sample &sample) {
    for (std::string line; in_.next(line);) {
        check_start(name(), line);
        if (in_.whole())
            line += '\n';
        if (parser_.parse(line, sample))
            return true;
    }
    return false;
}

std::vector<std::string> SampleReader::end(bool samples) {
    const toliman_series_info info = parser_.info();
    if (!samples)
        malformed(name(), info.lines == 0 ? "is empty" : "contains no samples");
    std::vector<std::string> warnings = take_warnings();
    if (info.missing > 0)
        warnings.push_back(
            name() + formatted(": %lld rows have no value and are skipped", static_cast<long long>(info.missing)));
    if (info.likely_instrument[0] != '\0')
        warnings.push_back(
            name() + ": column " + info.likely_instrument +
            " seems to name several instruments: without --instrument, the series is read as that of one");
    if (info.truncated != 0)
        warnings.push_back(where() + ": has no newline at its end; its last number may be truncated");
    return warnings;
}

double time_of(const std::string &option, const std::string &text, const SampleOptions &options, int32_t time_format,
               int32_t time_scale) {
    double number = 0;
    const bool is_number = number_of(text, number), plain = time_scale == 0;
    if (plain && !(is_number && std::isfinite(number)))
        throw Failure(kExitUsage, option + " " + text + ": must be a finite number, as the times of the series are");
    if (plain)
        return number;
    SampleOptions how = options_of_times(time_format, time_scale, options);
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

SampleOptions options_of_times(int32_t time_format, int32_t time_scale, const SampleOptions &options) {
    SampleOptions how = options;
    how.columns.clear();
    how.instrument.clear();
    for (const auto &[name, format] : kFormats)
        if (format == time_format && !name.empty())
            how.time_format = name;
    for (const auto &[name, scale] : kScales)
        if (how.time_scale.empty() && scale == time_scale && scale != TOLIMAN_INGEST_SCALE_TAI)
            how.time_scale = name; // of the column's name
    return how;
}

namespace {

toliman::measurements in_days(const toliman_measure *series, Progress &progress) {
    const double unit = info_of(series).time_unit_days;
    std::vector<double> times = values_of(series, "t");
    for (double &t : times)
        t *= unit;
    progress.warn(name_of(series) + formatted(": the times are converted to days, %g per unit", unit));
    auto data = toliman::sized<toliman_measure_data>();
    data.t = times.data();
    data.time_unit_days = 1;
    return changed(series, data);
}

} // namespace

toliman::measurements read_series(const std::string &name, const SampleOptions &options, Progress &progress) {
    const SampleParser options_are_valid(nullptr, options); // an error before the file is opened
    need(name, "a series of t, y[, sigma]",                 // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    const Content content = identify(name).content;
    if (content == Content::sums)
        check_start(name, "TLMP");
    auto how = toliman::sized<toliman_measure_options>();
    const LeapSeconds table(options.leap_seconds);
    set_options(options, table, how);
    if (!options.functions.empty()) {
        need(options.functions, "a CSV file of nuisance functions", {Content::text, Content::empty});
        how.functions = options.functions.c_str();
    }
    std::vector<std::string> warnings; // told once the series is accepted
    how.log = collect;
    how.log_data = &warnings;
    toliman_measure *made = nullptr;
    std::string source = name;
    toliman_status status = TOLIMAN_OK;
    if (content != Content::unknown && content != Content::empty) {
        status = toliman_measure_load_file(name.c_str(), &how, &made);
    } else {
        LineSource in(name, stop_if_asked);
        source = in.name();
        const std::string text = text_of(in);
        if (text.empty())
            malformed(source, "is empty");
        status = toliman_measure_load(text.data(), text.size(), source.c_str(), &how, &made);
    }
    if (status != TOLIMAN_OK)
        refuse(toliman::error(status), source, options);
    toliman::measurements series(made);
    const toliman_measure_info info = info_of(made);
    check_times(options, info.time_format);
    for (const std::string &warning : warnings)
        progress.warn(warning);
    return info.time_unit_days == 1 ? std::move(series) : in_days(made, progress);
}

toliman::measurements series_of(const std::string &name, const std::vector<double> &t, const std::vector<double> &y) {
    auto data = toliman::sized<toliman_measure_data>();
    data.name = name.c_str();
    data.n = t.size();
    data.t = t.data();
    data.y = y.data();
    return toliman::make<toliman::measurements>(toliman_measure_create, &data);
}

std::vector<Column> Samples::columns() const {
    std::vector<Column> columns = {{"t", &t}, {"y", &y}};
    if (!sigma.empty())
        columns.push_back({"sigma", &sigma});
    return columns;
}

} // namespace cli
