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

const double *data_or_null(const std::vector<double> &values) {
    return values.empty() ? nullptr : values.data();
}

// Whether a column is the offset of an instrument, which comes with the instruments.
bool is_offset(const std::string &name, const Series &series) {
    return std::any_of(series.instruments.begin(), series.instruments.end(),
                       [&](const std::string &instrument) { return name == "offset " + instrument; });
}

// The names of a list with commas.
std::vector<std::string> names_in(const std::string &list) {
    std::vector<std::string> names(1);
    for (const char letter : list)
        if (letter == ',')
            names.emplace_back();
        else
            names.back() += letter;
    return names;
}

void add_functions(const Series &series, toliman_measure *measure) {
    if (!series.instruments.empty())
        toliman::check(toliman_measure_set_instruments(measure, (joined(series.instruments, ",") + ",").c_str(),
                                                       series.instrument.data(), series.instrument.size()));
    const Nuisance &nuisance = series.nuisance;
    const Trend &trend = nuisance.trend;
    toliman::check(toliman_measure_set_trend(measure, trend.order, trend.start, trend.end));
    for (const NuisanceColumn &column : nuisance.columns)
        if (!is_offset(column.name, series))
            toliman::check(toliman_measure_add_column(measure, column.name.c_str(), column.values.data(),
                                                      column.values.size(), 0));
    for (size_t f = 0; f < nuisance.precision.size(); f++)
        if (nuisance.precision[f] > 0)
            toliman::check(
                toliman_measure_set_prior(measure, static_cast<int64_t>(f), 1 / std::sqrt(nuisance.precision[f])));
}

} // namespace

void add_times(CLI::App &command, SampleOptions &options) {
    command.add_option("--time-format", options.time_format)->check(CLI::IsMember({"days", "iso", "jd", "mjd"}));
    command.add_option("--time-scale", options.time_scale)->check(CLI::IsMember({"utc", "tai", "tt", "tdb", "gps"}));
}

void add_instrument(CLI::App &command, SampleOptions &options) {
    add_option(&command, "--instrument", options.instrument, "COLUMN");
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

double time_of(const std::string &option, const std::string &text, const SampleOptions &options, bool plain) {
    double number = 0;
    const bool is_number = number_of(text, number);
    if (plain && !(is_number && std::isfinite(number)))
        throw Failure(kExitUsage, option + " " + text + ": must be a finite number, as the times of the series are");
    if (plain)
        return number;
    SampleOptions how = options;
    how.columns.clear();
    how.instrument.clear();
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
    how.instrument.clear();
    for (const auto &[name, format] : kFormats)
        if (format == series.time_format && !name.empty())
            how.time_format = name;
    for (const auto &[name, scale] : kScales)
        if (how.time_scale.empty() && result_scale(name) == series.time_scale && series.time_scale != "TAI")
            how.time_scale = name; // of the column's name
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

Series read_series(const std::string &name, const SampleOptions &options, Progress &progress) {
    const SampleParser options_are_valid(nullptr, options); // an error before the file is opened
    need(name, "a series of t, y[, sigma]",                 // or sums: the reader states how to give them
         {Content::npy, Content::text, Content::json, Content::result, Content::empty, Content::sums});
    const Content content = identify(name).content;
    if (content == Content::sums)
        check_start(name, "TLMP");
    auto how = toliman::sized<toliman_measure_options>();
    const LeapSeconds table(options.leap_seconds);
    set_options(options, table, how);
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
    const toliman::measurements measure(made);
    Series series = series_of(measure.get(), source);
    check_times(options, series.time_format);
    for (const std::string &warning : warnings)
        progress.warn(warning);
    if (series.time_unit_days != 1) {
        for (double &t : series.t)
            t *= series.time_unit_days;
        progress.warn(source + formatted(": the times are converted to days, %g per unit", series.time_unit_days));
        series.time_unit_days = 1;
    }
    return series;
}

std::vector<Column> columns_of(const Series &series) {
    std::vector<Column> columns = {{"t", &series.t}, {"y", &series.y}};
    if (!series.sigma.empty())
        columns.push_back({"sigma", &series.sigma});
    return columns;
}

toliman::measurements measure_of(const Series &series, int32_t kind, double unit, const Exposures &exposures) {
    auto data = toliman::sized<toliman_measure_data>();
    data.kind = kind;
    data.n = series.t.size();
    data.t = series.t.data();
    data.y = series.y.data();
    data.sigma = data_or_null(series.sigma);
    data.intervals = exposures.intervals.empty() ? nullptr : exposures.intervals.data();
    data.interval_counts = exposures.counts.empty() ? nullptr : exposures.counts.data();
    data.position_angle_deg = data_or_null(series.position_angle_deg);
    data.unit = unit;
    data.time_unit_days = series.time_unit_days;
    data.frame_chi_square = series.frame_chi_square;
    auto measure = toliman::make<toliman::measurements>(toliman_measure_create, &data);
    add_functions(series, measure.get());
    return measure;
}

std::vector<std::vector<double>> functions_of(const Series &series) {
    const toliman::measurements measure = measure_of(series, 0, 0);
    std::vector<std::vector<double>> values;
    for (int64_t f = 0; f < info_of(measure.get()).functions; f++) {
        auto function = toliman::sized<toliman_measure_function>();
        toliman::check(toliman_measure_get_function(measure.get(), f, &function));
        values.push_back(values_of(measure.get(), function.name));
    }
    return values;
}

Series series_of(const toliman_measure *measure, const std::string &name) {
    const toliman_measure_info info = info_of(measure);
    Series series;
    series.name = name;
    series.t = values_of(measure, "t");
    series.y = values_of(measure, "y");
    series.sigma = values_of(measure, "sigma");
    series.position_angle_deg = values_of(measure, "position_angle_deg");
    series.time_scale = name_of_scale(info.time_scale);
    series.time_format = info.time_format;
    series.frame_chi_square = info.frame_chi_square;
    series.unit_name = info.unit_name;
    series.time_unit_days = info.time_unit_days;
    if (info.instruments > 0) {
        series.instruments = names_in(info.instrument_names);
        for (const double which : values_of(measure, "instrument"))
            series.instrument.push_back(std::llround(which));
    }
    Nuisance &nuisance = series.nuisance;
    nuisance.trend = {info.trend, info.trend_start, info.trend_end};
    bool has_priors = false;
    for (int64_t f = 0; f < info.functions; f++) {
        auto function = toliman::sized<toliman_measure_function>();
        toliman::check(toliman_measure_get_function(measure, f, &function));
        nuisance.precision.push_back(function.sigma > 0 ? 1 / (function.sigma * function.sigma) : 0);
        has_priors = has_priors || function.sigma > 0;
        if (f >= info.trend)
            nuisance.columns.push_back(
                {function.name, values_of(measure, function.name), function.bound, function.unit});
    }
    if (!has_priors)
        nuisance.precision.clear();
    return series;
}

} // namespace cli
