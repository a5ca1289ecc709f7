// Method: the library reads dates and days as text, exact to the nanosecond; they become Modified Julian Days in
// double, which resolve 0.6 us. UTC becomes TAI, because days of UTC differ in length. The other scales are uniform and
// are kept, so that a barycentric time in TDB stays one.
#include "series/times.hpp"

#include <CLI/App.hpp>
#include <algorithm>
#include <cctype>
#include <map>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"

namespace cli {

namespace {

const std::map<std::string, int32_t> kFormats = {{"days", 0},
                                                 {"iso", TOLIMAN_INGEST_FORMAT_ISO},
                                                 {"mjd", TOLIMAN_INGEST_FORMAT_MJD},
                                                 {"jd", TOLIMAN_INGEST_FORMAT_JD}};

// Whether the text begins as YYYY-MM-DD.
bool is_date(const std::string &text) {
    constexpr char kPattern[] = "0000-00-00";
    for (size_t i = 0; i + 1 < sizeof kPattern; i++)
        if (i >= text.size() || (kPattern[i] == '0') != (std::isdigit(static_cast<unsigned char>(text[i])) != 0) ||
            (kPattern[i] == '-') != (text[i] == '-'))
            return false;
    return true;
}

std::string in_case(std::string text, int (*to_case)(int)) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [&](unsigned char letter) { return static_cast<char>(to_case(letter)); });
    return text;
}

} // namespace

void add_times(CLI::App &command, TimeOptions &options) {
    command
        .add_option("--time-format", options.format,
                    "times are dates (iso), Modified Julian Days (mjd), Julian Days (jd) or plain numbers (days); "
                    "default: from the first time and the column's name")
        ->check(CLI::IsMember(kFormats));
    command
        .add_option("--time-scale", options.scale,
                    "time scale of dates, mjd and jd: utc (default), tai, tt, tdb or gps; utc becomes TAI")
        ->check(CLI::IsMember({"utc", "tai", "tt", "tdb", "gps"}));
}

std::string result_scale(const std::string &scale) {
    return scale.empty() || scale == "utc" ? "TAI" : in_case(scale, std::toupper);
}

void Times::begin(const std::string &column, const std::string &first) {
    const bool is_day = std::find(std::begin(kDayNames), std::end(kDayNames), column) != std::end(kDayNames);
    const std::string named = is_day ? in_case(column, std::tolower) : "days";
    format_ = kFormats.at(!options_.format.empty() ? options_.format : is_date(first) ? "iso" : named);
    if (plain() && !options_.scale.empty())
        throw Failure(kExitUsage,
                      "--time-scale " + options_.scale +
                          ": the times are plain numbers: give --time-format mjd or jd if they are such days");
    if (!plain() && options_.of_state && options_.scale.empty())
        throw Failure(kExitUsage, "--from-state: sums contain no time scale: give that of these times by --time-scale");
}

std::string Times::scale() const {
    return plain() ? "" : result_scale(options_.scale);
}

double Times::day_of(const std::string &text) const {
    constexpr int64_t kDay = 86400000000000, kDayOf1970 = 40587;
    const bool is_utc = options_.scale.empty() || options_.scale == "utc";
    int64_t ns = 0;
    if (text.find('\0') != std::string::npos)
        throw Failure(kExitInput, "contains a zero byte");
    if (toliman_ingest_parse_time(text.c_str(), format_, is_utc ? TOLIMAN_INGEST_SCALE_UTC : TOLIMAN_INGEST_SCALE_TAI,
                                  nullptr, 0, &ns) != TOLIMAN_OK)
        throw Failure(kExitInput, toliman_last_error() + std::string(options_.format.empty() && !is_date(text)
                                                                         ? "; --time-format days reads plain numbers"
                                                                         : ""));
    const int64_t days = ns / kDay - (ns % kDay < 0);
    return static_cast<double>(kDayOf1970 + days) + static_cast<double>(ns - days * kDay) / static_cast<double>(kDay);
}

} // namespace cli
