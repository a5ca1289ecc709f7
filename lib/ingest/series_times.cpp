// Method: dates and days are converted as text, exact to the nanosecond, and become Modified Julian Days. UTC becomes
// TAI, because days of UTC differ in length. The other scales are uniform and are kept, so that a barycentric time in
// TDB stays one. A column of Julian Days whose first value is near 59000 has JD - 2400000, which many tables call JD.
#include "ingest/series_times.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/fields.hpp"
#include "ingest/time_text.hpp"

namespace toliman::ingest {

namespace {

constexpr double kFirstReduced = 36204, kLastReduced = 88069; // 1958 to 2099
constexpr double kFirstYear = 1900, kLastYear = 2100;
constexpr const char *kScales[] = {"UTC", "TAI", "TT", "TDB", "GPS"};

bool is_plain_day_name(const std::string &name) {
    const std::string text = lower(name);
    return text == "jd" || text == "mjd";
}

} // namespace

void SeriesTimes::use_column(const std::string &name, const Unit &unit) {
    name_ = name;
    column_ = time_name(name).value_or(TimeName());
    if (const auto by_unit = time_name(unit.name); !column_.format && by_unit && by_unit->format)
        column_ = *by_unit; // "time [BJD - 2457000]"
    if (!options_.plain && options_.scale && column_.scale && options_.scale != column_.scale)
        fail(Status::mismatch, "{%s}: its times are in %s: must not be read as %s", name.c_str(),
             kScales[static_cast<size_t>(*column_.scale)], kScales[static_cast<size_t>(*options_.scale)]);
    if (unit.quantity != Quantity::unknown && unit.quantity != Quantity::time)
        fail(Status::mismatch, "{%s}: its unit is %s: must be one of time", name.c_str(), unit.name.c_str());
    unit_days_ = unit.quantity == Quantity::time ? unit.factor : 0;
    if (column_.format && unit_days_ != 0 && unit_days_ != 1)
        fail(Status::mismatch, "{%s}: its unit is %s: must be d", name.c_str(), unit.name.c_str());
}

std::string SeriesTimes::use_first(const std::string &time) {
    if (settled_)
        return "";
    format_ = options_.format;
    offset_ = 0;
    if (options_.plain)
        return "";
    if (!format_)
        format_ = begins_with_date(time) ? TimeFormat::iso : column_.format;
    offset_ = format_ == column_.format ? column_.offset : 0;
    double value = 0;
    if (format_ == TimeFormat::iso || !number_of(time, value))
        return "";
    const bool is_reduced = value >= kFirstReduced && value < kLastReduced;
    const std::string first = " = " + time.substr(0, 40) + ": ";
    if (format_ == TimeFormat::jd && offset_ == 0 && is_reduced) {
        offset_ = kReducedJd;
        return (name_.empty() ? "t" : name_) + first + "the times are taken as JD - 2400000";
    }
    const bool is_jd = value >= 1e6;
    if (!options_.format && format_ == TimeFormat::jd && offset_ == 0 && !is_jd && !is_plain_day_name(name_)) {
        format_.reset();
        return name_ + first + "the times are neither Julian Days nor JD - 2400000: they are taken as plain numbers";
    }
    const std::string base = lower(split_unit(name_).name);
    if (!format_ && base.find("date") != base.npos)
        fail(Status::format, "{t} = \"%.60s\": must be YYYY-MM-DD in a column {%s}, alone or with Thh:mm:ss",
             time.c_str(), name_.c_str());
    if (!format_ && !name_.empty() && base != "t" && unit_days_ == 0 && value >= kFirstYear && value < kLastYear)
        return name_ + first + "the times may be years, and are taken as days";
    return "";
}

double SeriesTimes::day_of(const std::string &text) const {
    if (text.find('\0') != std::string::npos)
        fail(Status::format, "{t}: contains a zero byte");
    try {
        const Scale kept = given() == Scale::utc ? Scale::utc : Scale::tai; // no conversion of other scales
        const int64_t ns = parse_time(text.c_str(), *format_, kept, options_.leap_seconds, offset_);
        const int64_t days = ns / kDay - (ns % kDay < 0);
        return static_cast<double>(kDayOf1970 + days) +
               static_cast<double>(ns - days * kDay) / static_cast<double>(kDay);
    } catch (const Error &error) {
        fail(Status::format, "{t}: %s", error.what());
    }
}

} // namespace toliman::ingest
