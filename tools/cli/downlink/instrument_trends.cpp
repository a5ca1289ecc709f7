// Method: a line by least squares, with equal weights: frames differ from it by drift, pointing and jitter of the
// spacecraft rather than by photon noise. Frames beyond 6 robust standard deviations (1.4826 times the median absolute
// deviation) of the median are left out first. The sigma of the slope is that of independent frames with the scatter
// about the line. A significant trend has 5 sigmas and exceeds three times this scatter from the first to the last
// frame: the former alone would report changes that do not matter, of thousands of frames.
#include "downlink/instrument_trends.hpp"

#include "common/median.hpp"
#include "downlink/folder_facts.hpp"
#include "downlink/ledger_report.hpp"

namespace cli {

namespace {

constexpr double kYearNs = 365.25 * 86400e9;
constexpr double kOutlier = 6, kGaussian = 1.4826; // MAD of a Gaussian: sigma/1.4826
constexpr double kSigmas = 5, kScatters = 3;

double robust_rms(std::vector<double> values, double centre) {
    for (double &value : values)
        value = std::fabs(value - centre);
    return kGaussian * median(std::move(values));
}

struct Point {
    double years, value;
};

// Sets per_year, sigma_per_year and scatter.
void fit_line(const std::vector<Point> &points, InstrumentTrend &trend) {
    const auto n = static_cast<double>(points.size());
    double time = 0, mean = 0, xx = 0, xy = 0, squares = 0;
    for (const Point &point : points) {
        time += point.years / n;
        mean += point.value / n;
    }
    for (const Point &point : points) {
        xx += (point.years - time) * (point.years - time);
        xy += (point.years - time) * (point.value - mean);
    }
    trend.per_year = xy / xx;
    for (const Point &point : points) {
        const double rest = point.value - mean - trend.per_year * (point.years - time);
        squares += rest * rest;
    }
    trend.scatter = std::sqrt(squares / (n - 2));
    trend.sigma_per_year = trend.scatter / std::sqrt(xx);
}

// Nothing for too few frames or a constant.
std::optional<InstrumentTrend> trend_of(const std::string &name, const std::string &unit,
                                        const std::vector<double> &years, const std::vector<double> &values) {
    std::vector<double> known;
    std::copy_if(values.begin(), values.end(), std::back_inserter(known), [](double v) { return std::isfinite(v); });
    if (known.size() < kLeastFrames)
        return std::nullopt;
    InstrumentTrend trend = {name, unit, median(known), 0, 0, 0, 0, 0};
    trend.rms = robust_rms(known, trend.median);
    std::vector<Point> points;
    for (size_t i = 0; i < values.size(); i++)
        if (std::fabs(values[i] - trend.median) <= kOutlier * trend.rms) // not of NaN
            points.push_back({years[i], values[i]});
    const auto [first, last] = std::minmax_element(points.begin(), points.end(),
                                                   [](const Point &a, const Point &b) { return a.years < b.years; });
    if (!(trend.rms > 0) || points.size() < kLeastFrames || last->years - first->years < kLeastYears)
        return std::nullopt;
    trend.years = last->years - first->years;
    fit_line(points, trend);
    return trend;
}

// The columns with a trend, and their units.
std::vector<std::pair<std::string, std::string>> columns_in(const toliman::tracker &tracker) {
    std::map<std::string, std::string> units = {{"chi_square", ""}, {"x_px", "px"}, {"y_px", "px"}};
    for (const auto &parameter :
         all_of<toliman_sim_parameter>([](toliman_sim_parameter *items, size_t capacity, size_t *count) {
             return toliman_sim_get_parameters(items, capacity, count);
         }))
        units.emplace(parameter.name, parameter.unit);
    std::vector<std::pair<std::string, std::string>> columns;
    for (const auto &column :
         all_of<toliman_track_column>([&](toliman_track_column *items, size_t capacity, size_t *count) {
             return toliman_track_get_columns(tracker.get(), items, capacity, count);
         }))
        if (const auto found = units.find(column.name); found != units.end())
            columns.emplace_back(*found);
    return columns;
}

struct Frames {
    std::vector<size_t> records; // their numbers
    std::vector<double> years;   // since the first
    std::vector<int64_t> tai_ns;
    size_t all = 0; // records
};

Frames frames_of(const toliman::tracker &tracker) {
    Frames frames;
    each_record(tracker, [&](const toliman_track_record &record) {
        const size_t number = frames.all++;
        if (record.verdict != TOLIMAN_TRACK_VERDICT_ACCEPTED && record.verdict != TOLIMAN_TRACK_VERDICT_UNREDUCED)
            return;
        frames.records.push_back(number);
        frames.tai_ns.push_back(record.tai_ns);
        const auto first_ns = static_cast<double>(frames.tai_ns.front());
        frames.years.push_back((static_cast<double>(record.tai_ns) - first_ns) / kYearNs);
    });
    return frames;
}

std::vector<double> values_of(const toliman::tracker &tracker, const std::string &column, const Frames &frames) {
    const std::vector<double> all = column_of(tracker, column, 0, frames.all);
    std::vector<double> values;
    for (const size_t i : frames.records)
        values.push_back(all[i]);
    return values;
}

bool is_always_told(const std::string &name) {
    return name == "x_px" || name == "y_px" || name == "focus" || name.rfind("flux_", 0) == 0 ||
           name.rfind("jitter_", 0) == 0;
}

} // namespace

bool InstrumentTrend::is_significant() const {
    const double change = std::fabs(per_year) * years;
    return change > kScatters * scatter && std::fabs(per_year) > kSigmas * sigma_per_year;
}

std::vector<InstrumentTrend> trends_of(const toliman::tracker &tracker) {
    const Frames frames = frames_of(tracker);
    std::vector<InstrumentTrend> trends;
    if (frames.records.size() < kLeastFrames)
        return trends;
    for (const auto &[name, unit] : columns_in(tracker))
        if (std::optional<InstrumentTrend> trend = trend_of(name, unit, frames.years, values_of(tracker, name, frames)))
            trends.push_back(*std::move(trend));
    return trends;
}

std::vector<FrameColumn> frames_over_time(const toliman::tracker &tracker) {
    const Frames frames = frames_of(tracker);
    if (frames.records.size() < kLeastFrames)
        return {};
    std::vector<FrameColumn> columns = {{"t", {}}};
    const toliman_track_options how = settings_of(tracker);
    for (const int64_t tai_ns : frames.tai_ns)
        columns[0].values.push_back(time_of(tai_ns, how));
    for (const auto &[name, unit] : columns_in(tracker))
        columns.push_back({name, values_of(tracker, name, frames)});
    return columns;
}

std::string text_of(const std::vector<InstrumentTrend> &trends) {
    std::string text;
    for (const InstrumentTrend &trend : trends)
        if (is_always_told(trend.name) || (trend.is_significant() && trend.name != "chi_square"))
            text += formatted("  %-13s median %+.3g, rms %.2g%s%s; trend %s per year%s\n", trend.name.c_str(),
                              trend.median, trend.rms, trend.unit.empty() ? "" : " ", trend.unit.c_str(),
                              text_with_error(trend.per_year, trend.sigma_per_year).c_str(),
                              trend.is_significant() ? ": drifts" : "");
    return text;
}

std::vector<Json> json_of(const std::vector<InstrumentTrend> &trends) {
    return array_of(trends, [](const InstrumentTrend &trend) {
        return Json("name", trend.name, "unit", trend.unit, "median", trend.median, "rms", trend.rms, "per_year",
                    trend.per_year, "sigma_per_year", trend.sigma_per_year, "significant", trend.is_significant());
    });
}

} // namespace cli
