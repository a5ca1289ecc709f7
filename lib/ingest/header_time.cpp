// Method: the first keyword of kRules that the header has together with its exposure gives the time, otherwise the
// first one that it has at all. MJD-AVG and DATE-AVG are the middle of the exposure; to the others half of the exposure
// is added. TIMESYS gives the scale, UTC by default. Reference: FITS Standard 4.0, section 9 (Time coordinates).
#include "ingest/header_time.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "base/error.hpp"
#include "ingest/time_scale.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr int64_t kSecond = 1000000000, kDay = 86400 * kSecond, kDayOf1970 = 40587, kLongestExposure = 1000000000;

struct Rule {
    const char *time, *exposure; // keywords; exposure: NULL if the time is the middle of it
    TimeFormat format;
};
constexpr Rule kRules[] = {{"MJD-AVG", nullptr, TimeFormat::mjd},
                           {"DATE-AVG", nullptr, TimeFormat::iso},
                           {"MJD-BEG", "XPOSURE", TimeFormat::mjd},
                           {"MJD-OBS", "EXPTIME", TimeFormat::mjd},
                           {"DATE-OBS", "EXPTIME", TimeFormat::iso}};

struct NamedScale {
    const char *name;
    Scale scale;
};
constexpr NamedScale kScales[] = {{"UTC", Scale::utc},    {"TAI", Scale::tai}, {"IAT", Scale::tai}, {"TT", Scale::tt},
                                  {"TT(TAI)", Scale::tt}, {"TDT", Scale::tt},  {"GPS", Scale::gps}};

// A string of a header without its quotes.
std::string unquoted(const std::string &value) {
    if (value.size() < 2 || value.front() != '\'' || value.back() != '\'')
        return value;
    const std::string text = value.substr(1, value.size() - 2);
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

const NamedScale &scale_of(const char *value) {
    if (value == nullptr)
        return kScales[0];
    std::string name = unquoted(value);
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
    for (const NamedScale &scale : kScales)
        if (name == scale.name)
            return scale;
    fail(Status::format, "{TIMESYS} = %.70s: must be UTC, TAI, TT, TDT, IAT or GPS", value);
}

const Rule &rule_of(const Keywords &value_of) {
    const Rule *incomplete = nullptr;
    for (const Rule &rule : kRules) {
        if (value_of(rule.time) == nullptr)
            continue;
        if (rule.exposure == nullptr || value_of(rule.exposure) != nullptr)
            return rule;
        incomplete = incomplete != nullptr ? incomplete : &rule;
    }
    if (incomplete == nullptr)
        fail(Status::not_found, "{header} has no time: none of MJD-AVG, DATE-AVG, MJD-BEG, MJD-OBS and DATE-OBS");
    return *incomplete;
}

// A date of a FITS header has no final Z in any scale.
int64_t time_of(const Rule &rule, const char *value, Scale scale, const LeapSeconds &leap_seconds) {
    const bool is_date = rule.format == TimeFormat::iso;
    const std::string text = is_date ? unquoted(value) : value;
    int64_t tai_ns = 0;
    try {
        tai_ns = parse_time(text.c_str(), rule.format, scale, leap_seconds);
    } catch (const Error &error) {
        fail(error.status(), "{%s}: %s", rule.time, error.what());
    }
    if (text.back() == 'Z')
        fail(Status::format, "{%s} = %.70s: must be YYYY-MM-DDThh:mm:ss without a Z", rule.time, value);
    return tai_ns;
}

// Half of an exposure, ns; 0 without one. Days parses any decimal number without rounding.
int64_t half_of(const char *key, const char *value) {
    if (value == nullptr)
        return 0;
    const std::optional<Days> seconds = Days::parse(value);
    const bool is_known = seconds && seconds->whole() >= 0 && seconds->whole() <= kLongestExposure;
    const int64_t half = is_known ? seconds->whole() * (kSecond / 2) + seconds->rest(kSecond / 2) : -1;
    if (half < 0 || half > kLongestExposure * (kSecond / 2))
        fail(Status::format, "{%s} = %.70s: must be from 0 to 1e9 s", key, value);
    return half;
}

} // namespace

HeaderTime header_time(const Keywords &value_of, const LeapSeconds &leap_seconds, int64_t expires) {
    const Rule &rule = rule_of(value_of);
    const char *const timesys = value_of("TIMESYS");
    const char *const exposure = rule.exposure != nullptr ? value_of(rule.exposure) : nullptr;
    const bool is_start = rule.exposure != nullptr && exposure == nullptr;
    const NamedScale &scale = scale_of(timesys);
    const int64_t tai_ns = time_of(rule, value_of(rule.time), scale.scale, leap_seconds);
    const int64_t utc_ns = tai_ns - leap_seconds.tai_utc(expires).value_or(0) * kSecond;
    return {tai_ns + half_of(rule.exposure, exposure), timesys == nullptr || is_start,
            scale.scale == Scale::utc && utc_ns / kDay + kDayOf1970 >= expires,
            rule.time + (exposure != nullptr ? std::string(" + ") + rule.exposure + "/2" : "") +
                (is_start ? std::string(", taken as mid-exposure as ") + rule.exposure + " is missing," : "") + " in " +
                scale.name + (timesys == nullptr ? ", as TIMESYS is missing" : "")};
}

} // namespace toliman::ingest
