// Method: the times from --from to --to are counted in days of their own scale: both ends are read as TAI, where a day
// has 86,400 s, and every time is written as a date, which is then read in its scale.
#include "scenes/sky_times.hpp"

#include <cctype>
#include <charconv>

#include "common/lines.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

const std::map<std::string, int32_t> kScales = {{"utc", TOLIMAN_INGEST_SCALE_UTC},
                                                {"tai", TOLIMAN_INGEST_SCALE_TAI},
                                                {"tt", TOLIMAN_INGEST_SCALE_TT},
                                                {"tdb", TOLIMAN_INGEST_SCALE_TDB},
                                                {"gps", TOLIMAN_INGEST_SCALE_GPS}};
constexpr double kLargestYear = 9999, kFirstJulianDay = 2e6;
constexpr double kMostTimes = 1e6, kNsPerDay = 86400e9;

} // namespace

int64_t read_time(const std::string &where, const std::string &text, int32_t scale,
                  const std::vector<toliman_leap_second> &leap_seconds) {
    double number = 0;
    int32_t format = TOLIMAN_INGEST_FORMAT_ISO;
    if (number_of(text, number)) {
        format = number < kFirstJulianDay ? TOLIMAN_INGEST_FORMAT_MJD : TOLIMAN_INGEST_FORMAT_JD;
        if (std::fabs(number) <= kLargestYear)
            throw Failure(kExitUsage, where + " " + text +
                                          ": must be a date (2027-07-02T12:00:00), a Modified Julian Day or a Julian "
                                          "Day");
    }
    int64_t tai_ns = 0;
    const std::string prefix = "text = \"" + text + "\"";
    try {
        toliman::check(
            toliman_ingest_parse_time(text.c_str(), format, scale, leap_seconds.data(), leap_seconds.size(), &tai_ns));
    } catch (const toliman::error &error) {
        throw Failure(kExitUsage, where + " " + text + std::string(error.what()).substr(prefix.size()));
    }
    return tai_ns;
}

int64_t read_epoch(const std::string &where, const std::string &text,
                   const std::vector<toliman_leap_second> &leap_seconds) {
    constexpr int64_t kLeastNs = 1000000000; // above all days
    int64_t ns = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ns);
    if (error == std::errc() && end == text.data() + text.size() && (ns >= kLeastNs || ns <= -kLeastNs))
        return ns;
    return read_time(where, text, TOLIMAN_INGEST_SCALE_UTC, leap_seconds);
}

namespace {

std::vector<SkyTime> times_of_range(const SkyTimeOptions &options,
                                    const std::vector<toliman_leap_second> &leap_seconds) {
    const int64_t first = read_time("--from", options.from, TOLIMAN_INGEST_SCALE_TAI, {});
    const int64_t last = read_time("--to", options.to, TOLIMAN_INGEST_SCALE_TAI, {});
    const double days = options.every.value_or(1);
    if (!(days * kNsPerDay >= 1) || !std::isfinite(days))
        throw Failure(kExitUsage, formatted("--every %g: must be at least 1 ns, in days", days));
    if (last < first)
        throw Failure(kExitUsage, "--to " + options.to + ": must not be before --from " + options.from);
    const double length = static_cast<double>(last - first), step = days * kNsPerDay;
    if (!(length / step < kMostTimes))
        throw Failure(kExitUsage, formatted("--every %g: more than %.0f times", days, kMostTimes));
    std::vector<SkyTime> times;
    for (double k = 0; std::llround(k * step) <= last - first; k++) {
        const std::string text = date_text(first + std::llround(k * step));
        times.push_back({text, read_time("--from", text, kScales.at(options.scale), leap_seconds)});
    }
    return times;
}

// The first field of a line: up to a blank or a separator, but a date and a time that one blank separates are one
// field.
std::string field_of(const std::string &line, size_t start) {
    constexpr char kEnds[] = " \t\r\n,;";
    const size_t end = std::min(line.find_first_of(kEnds, start), line.size());
    const bool continues = line.size() > end + 3 && line[end] == ' ' && line[end + 3] == ':' &&
                           line.find('-', start) < end && line.find(':', start) > end;
    return line.substr(start, (continues ? std::min(line.find_first_of(kEnds, end + 1), line.size()) : end) - start);
}

// The first field of every line; a first line that begins with a letter contains names.
std::vector<SkyTime> times_of_file(const SkyTimeOptions &options,
                                   const std::vector<toliman_leap_second> &leap_seconds) {
    LineSource source(options.file, stop_if_asked);
    std::vector<SkyTime> times;
    std::string line;
    bool is_first = true;
    for (size_t number = 1; source.next(line); number++) {
        if (number == 1 && line.compare(0, 3, "\xef\xbb\xbf") == 0) // the byte order mark that some editors write
            line.erase(0, 3);
        const size_t start = line.find_first_not_of(" \t\r\n");
        if (start == std::string::npos || line[start] == '#')
            continue;
        const std::string text = field_of(line, start);
        if (std::exchange(is_first, false) && std::isalpha(static_cast<unsigned char>(text[0])) != 0)
            continue;
        try {
            times.push_back({text, read_time(":", text, kScales.at(options.scale), leap_seconds)});
        } catch (const Failure &failure) {
            malformed(source.name(), "line " + std::to_string(number) + failure.what());
        }
    }
    if (times.empty())
        malformed(source.name(), "contains no times");
    return times;
}

} // namespace

void add_sky_times(CLI::App &command, SkyTimeOptions &options) {
    CLI::Option *const times = command.add_option("--times", options.times);
    times->type_name("TIME,...")->delimiter(',')->allow_extra_args(false);
    CLI::Option *const file = command.add_option("--times-file", options.file);
    file->type_name("FILE")->excludes(times);
    CLI::Option *const from = command.add_option("--from", options.from);
    from->type_name("TIME")->excludes(times)->excludes(file);
    CLI::Option *const to = command.add_option("--to", options.to);
    to->type_name("TIME")->needs(from);
    from->needs(to);
    command.add_option("--every", options.every)->type_name("DAYS")->needs(from);
    command.add_option("--scale", options.scale)->check(CLI::IsMember({"utc", "tai", "tt", "tdb", "gps"}));
}

std::vector<SkyTime> sky_times(const SkyTimeOptions &options, const std::vector<toliman_leap_second> &leap_seconds) {
    if (!options.file.empty())
        return times_of_file(options, leap_seconds);
    if (!options.from.empty())
        return times_of_range(options, leap_seconds);
    if (options.times.empty())
        throw Failure(kExitUsage, "give times: --times, --times-file, or --from and --to");
    std::vector<SkyTime> times;
    for (const std::string &text : options.times)
        times.push_back({text, read_time("--times", text, kScales.at(options.scale), leap_seconds)});
    return times;
}

} // namespace cli
