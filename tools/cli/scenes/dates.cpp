// Method: Julian year 2000.0 is JD 2451545.0, 2000-01-01 12 h; the calendar is that of the C library, whose day 0 is
// JD 2440587.5.
#include "scenes/dates.hpp"

#include "common/common.hpp"

#include <ctime>

#include <toliman/ingest.h>

#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr int64_t kNsPerSecond = 1000000000;
constexpr double kDay = 86400, kEpochYear = 2000, kEpochDay = 2451545.0 - 2440587.5;

} // namespace

std::optional<double> date_of(const Scene &scene) {
    const JsonTree tree = read_scene_json(scene.path);
    const cJSON *const binary = item_of(tree.get(), "binary"), *const date = item_of(binary, "date");
    if (cJSON_IsTrue(item_of(binary, "moving")) == 0 || cJSON_IsNumber(date) == 0)
        return std::nullopt;
    return date->valuedouble;
}

std::optional<double> year_of(const std::string &text) {
    double year = 0;
    if (number_of(text, year))
        return std::isfinite(year) ? std::optional(year) : std::nullopt;
    int64_t ns = 0;
    if (toliman_ingest_parse_time(text.c_str(), TOLIMAN_INGEST_FORMAT_ISO, TOLIMAN_INGEST_SCALE_TAI, nullptr, 0, &ns) !=
        TOLIMAN_OK)
        return std::nullopt;
    return kEpochYear + (static_cast<double>(ns) / (kDay * 1e9) - kEpochDay) / kDaysPerYear;
}

std::string day_text(double zero, double days) {
    const double seconds = ((zero - kEpochYear) * kDaysPerYear + kEpochDay + days) * kDay;
    const auto whole = static_cast<std::time_t>(std::floor(seconds + 0.5)); // a year has not all bits of its second
    std::tm parts = {};
    ::gmtime_r(&whole, &parts);
    return formatted("%04d-%02d-%02d", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
}

std::string date_text(int64_t ns) {
    const int64_t below = ((ns % kNsPerSecond) + kNsPerSecond) % kNsPerSecond;
    const std::time_t seconds = (ns - below) / kNsPerSecond;
    std::tm parts = {};
    ::gmtime_r(&seconds, &parts);
    std::string text = formatted("%04d-%02d-%02dT%02d:%02d:%02d", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                                 parts.tm_hour, parts.tm_min, parts.tm_sec);
    if (below == 0)
        return text;
    text += formatted(".%09lld", static_cast<long long>(below));
    return text.erase(text.find_last_not_of('0') + 1);
}

namespace {

std::string mjd_text(double mjd, size_t length) {
    constexpr double kOf1970 = 40587, kNsPerDay = 86400e9;
    return date_text(std::llround((mjd - kOf1970) * kNsPerDay)).substr(0, length);
}

} // namespace

std::string mjd_day(double mjd) {
    return mjd_text(mjd, std::strlen("2027-01-01"));
}

std::string mjd_minute(double mjd) {
    return mjd_text(mjd, std::strlen("2027-01-01T00:00"));
}

} // namespace cli
