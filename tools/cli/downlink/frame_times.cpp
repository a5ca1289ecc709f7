#include "downlink/frame_times.hpp"

#include <cctype>
#include <cmath>

#include "common/failure.hpp"
#include "common/time_text.hpp"

namespace cli {

namespace {

constexpr int64_t kSecond = 1000000000;
constexpr int64_t kFirstDay = 36204, kEndDay = 88069, kDayOf1970 = 40587; // 1958-01-01, when TAI began, to 2100-01-01

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

// TAI is the scale plus this; of UTC the leap seconds say it.
struct Scale {
    const char *name;
    int64_t ahead_ns;
};
constexpr Scale kScales[] = {
    {"UTC", 0},          {"TAI", 0}, {"IAT", 0}, {"TT", -32184000000}, {"TT(TAI)", -32184000000}, {"TDT", -32184000000},
    {"GPS", 19000000000}};

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

// Day and time of a keyword. A day of UTC with a leap second is as much longer, and so is the unit of its fraction.
DayTime time_of(FrameFile &file, const Rule &rule, const std::string &value, const LeapSeconds *utc) {
    const std::string where = std::string(rule.time) + " = " + value;
    const bool is_mjd = rule.time[0] == 'M';
    DayTime time = {};
    if (is_mjd) {
        const std::optional<int64_t> ns = times_unit(value, 86400 * kSecond);
        if (!ns || *ns < 0)
            malformed(file.path(), where + ": must be a Modified Julian Day, 36204 (1958-01-01) to 88068 (2099-12-31)");
        time.day = *ns / (86400 * kSecond);
    } else {
        const std::optional<DayTime> date = read_date(unquoted(value));
        if (!date)
            malformed(file.path(), where + ": must be YYYY-MM-DD or YYYY-MM-DDThh:mm:ss[.s...]");
        time = *date;
    }
    if (time.day < kFirstDay || time.day >= kEndDay)
        malformed(file.path(), where + ": must be from 1958-01-01 to 2099-12-31");
    if (utc != nullptr && !utc->ahead(time.day))
        malformed(file.path(), where + ": UTC must be from 1972-01-01 on, when leap seconds began");
    const int64_t length = (utc != nullptr ? utc->seconds_of(time.day) : 86400) * kSecond;
    if (is_mjd)
        time.ns = *times_unit(value, length) - time.day * length;
    if (!is_mjd && time.ns >= length)
        malformed(file.path(), where + ": that day has no such second");
    return time;
}

int64_t half_of(FrameFile &file, const char *key, const std::string &value) {
    constexpr int64_t kMost = 1000000000; // s
    const std::optional<int64_t> half = times_unit(value, kSecond / 2);
    if (!half || *half < 0 || *half > kMost / 2 * kSecond)
        malformed(file.path(), std::string(key) + " = " + value + ": must be from 0 to 1e9 s");
    return *half;
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

// False where there are none.
bool FrameTimes::read_keywords(FrameFile &file, const LeapSeconds &leap_seconds) {
    const std::optional<Keywords> found = find_keywords(file);
    if (!found)
        return false;
    const Rule &rule = *found->rule;
    const Scale &scale = scale_of(file, assumed_);
    const LeapSeconds *utc = &scale == kScales ? &leap_seconds : nullptr;
    const DayTime time = time_of(file, rule, found->time, utc);
    first_ = (time.day - kDayOf1970) * 86400 * kSecond + time.ns + scale.ahead_ns +
             (utc != nullptr ? *utc->ahead(time.day) * kSecond : 0) +
             (found->exposure ? half_of(file, rule.exposure, *found->exposure) : 0);
    beyond_ = utc != nullptr && time.day >= utc->expires();
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
