#include "downlink/frame_times.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr int64_t kDay = 86400000000000, kDayOf1970 = 40587;

// Keywords of the time, and of the exposure (s) of which half is added; the first rule that is there holds, or else the
// first of which the time is there.
struct Rule {
    const char *time, *exposure;
};
constexpr Rule kRules[] = {{"MJD-AVG", nullptr},
                           {"DATE-AVG", nullptr},
                           {"MJD-BEG", "XPOSURE"},
                           {"MJD-OBS", "EXPTIME"},
                           {"DATE-OBS", "EXPTIME"}};

struct Scale {
    const char *name;
    int32_t scale;
};
constexpr Scale kScales[] = {{"UTC", TOLIMAN_INGEST_SCALE_UTC},    {"TAI", TOLIMAN_INGEST_SCALE_TAI},
                             {"IAT", TOLIMAN_INGEST_SCALE_TAI},    {"TT", TOLIMAN_INGEST_SCALE_TT},
                             {"TT(TAI)", TOLIMAN_INGEST_SCALE_TT}, {"TDT", TOLIMAN_INGEST_SCALE_TT},
                             {"GPS", TOLIMAN_INGEST_SCALE_GPS}};

// A string of a header without its quotes.
std::string unquoted(const std::string &value) {
    if (value.size() < 2 || value.front() != '\'' || value.back() != '\'')
        return value;
    const std::string text = value.substr(1, value.size() - 2);
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

const Scale &scale_of(FrameFile &file, bool &assumed) {
    const std::optional<std::string> value = file.value_of("TIMESYS");
    assumed = !value;
    std::string name = value ? unquoted(*value) : kScales[0].name;
    for (char &letter : name)
        letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    for (const Scale &scale : kScales)
        if (name == scale.name)
            return scale;
    malformed(file.path(), "TIMESYS = " + *value + ": must be UTC, TAI, TT, TDT, IAT or GPS");
}

// TAI of a keyword, ns. A date of a FITS header has no final Z, in any scale.
int64_t time_of(const FrameFile &file, const Rule &rule, const std::string &value, const Scale &scale,
                const LeapSeconds &leap_seconds) {
    const bool is_mjd = rule.time[0] == 'M';
    const std::string text = is_mjd ? value : unquoted(value);
    int64_t tai_ns = 0;
    if (toliman_ingest_parse_time(text.c_str(), is_mjd ? TOLIMAN_INGEST_FORMAT_MJD : TOLIMAN_INGEST_FORMAT_ISO,
                                  scale.scale, leap_seconds.rows.data(), leap_seconds.rows.size(),
                                  &tai_ns) != TOLIMAN_OK)
        malformed(file.path(), std::string(rule.time) + ": " + toliman_last_error());
    if (text.back() == 'Z')
        malformed(file.path(), std::string(rule.time) + " = " + value + ": must be YYYY-MM-DDThh:mm:ss without a Z");
    return tai_ns;
}

// Half an exposure in s, in ns. The exponent of a FITS number may be a D.
int64_t half_of(const FrameFile &file, const char *key, const std::string &value) {
    std::string text = value;
    std::replace_if(
        text.begin(), text.end(), [](char letter) { return letter == 'D' || letter == 'd'; }, 'E');
    double seconds = 0;
    if (!number_of(text, seconds) || !(seconds >= 0 && seconds <= 1e9))
        malformed(file.path(), std::string(key) + " = " + value + ": must be from 0 to 1e9 s");
    return std::llround(seconds * 5e8);
}

struct Keywords {
    const Rule *rule;
    std::string time;
    std::optional<std::string> exposure;
};

std::optional<Keywords> find_keywords(FrameFile &file) {
    std::optional<Keywords> without;
    for (const Rule &rule : kRules) {
        const std::optional<std::string> time = file.value_of(rule.time);
        const std::optional<std::string> exposure =
            rule.exposure != nullptr ? file.value_of(rule.exposure) : std::nullopt;
        if (!time)
            continue;
        if (rule.exposure == nullptr || exposure)
            return Keywords{&rule, *time, exposure};
        if (!without)
            without = Keywords{&rule, *time, std::nullopt};
    }
    return without;
}

} // namespace

LeapSeconds::LeapSeconds(const std::string &path) {
    const char *const name = path.empty() ? nullptr : path.c_str();
    size_t count = 0;
    toliman::check(toliman_ingest_read_leap_seconds(name, nullptr, 0, &count, nullptr));
    rows.assign(count, toliman::sized<toliman_leap_second>());
    toliman::check(toliman_ingest_read_leap_seconds(name, rows.data(), count, &count, &expires));
    rows.resize(count);
}

int64_t LeapSeconds::end_ns() const noexcept {
    return (expires - kDayOf1970) * kDay + rows.back().tai_utc_s * int64_t{1000000000};
}

// False where there are none.
bool FrameTimes::read_keywords(FrameFile &file, const LeapSeconds &leap_seconds) {
    const std::optional<Keywords> found = find_keywords(file);
    if (!found)
        return false;
    const Rule &rule = *found->rule;
    const Scale &scale = scale_of(file, assumed_);
    const int64_t tai_ns = time_of(file, rule, found->time, scale, leap_seconds);
    first_ = tai_ns + (found->exposure ? half_of(file, rule.exposure, *found->exposure) : 0);
    beyond_ = scale.scale == TOLIMAN_INGEST_SCALE_UTC && tai_ns >= leap_seconds.end_ns();
    const bool halved = rule.exposure == nullptr || found->exposure;
    rule_ = rule.time + (found->exposure ? std::string(" + ") + rule.exposure + "/2" : "") +
            (halved ? "" : std::string(", taken as mid-exposure as ") + rule.exposure + " is missing,") + " in " +
            scale.name + (assumed_ ? ", as TIMESYS is missing" : "");
    assumed_ = assumed_ || !halved;
    return true;
}

FrameTimes::FrameTimes(FrameFile &file, int64_t number, const std::optional<double> &cadence,
                       const LeapSeconds &leap_seconds)
    : path_(file.path()), cadence_(cadence) {
    is_tai_ = read_keywords(file, leap_seconds);
    for (const double days : file.days()) {
        constexpr double kMost = 20000; // so that sums of times fit
        const std::optional<int64_t> ns = ns_of_days(days);
        if (!ns || std::fabs(days) > kMost)
            malformed(path_, "table FRAMES: a time of " + std::to_string(days) + " days: must be within 20,000 days");
        steps_.push_back(*ns);
    }
    const bool by_table = !steps_.empty();
    if (by_table) {
        const int64_t first = steps_.front();
        first_ = is_tai_ ? first_ : first;
        for (int64_t &step : steps_)
            step -= first;
    }
    if (!by_table && !cadence_ && !is_tai_)
        malformed(path_, "tells no time: needs --cadence SECONDS");
    if (!by_table && !cadence_ && file.count() > 1)
        malformed(path_, "tells the time of its first frame only: needs --cadence SECONDS");
    by_cadence_ = !by_table && (!is_tai_ || file.count() > 1);
    number_ = by_table || is_tai_ ? 0 : number;
    const std::string step = by_table ? "its table FRAMES" : number_ != 0 ? "FRAME1 and --cadence" : "--cadence";
    if (!is_tai_)
        rule_ = step + ", by the camera's clock";
    else if (file.count() > 1)
        rule_ += ", from there on by " + step;
}

int64_t FrameTimes::at(size_t frame) const {
    constexpr double kMost = 4e18; // ns, so that sums of times fit
    if (!steps_.empty())
        return first_ + steps_[frame];
    const int64_t steps = number_ + static_cast<int64_t>(frame);
    if (steps == 0)
        return first_;
    const double step = static_cast<double>(steps) * *cadence_ * 1e9;
    if (!(std::fabs(step) < kMost))
        malformed(path_, "frame " + std::to_string(steps) + " is more than 4e9 s from frame 0");
    return first_ + std::llround(step);
}

} // namespace cli
