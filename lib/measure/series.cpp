// Method: T_0 = 1, T_1 = x, T_j+1 = 2 x T_j - T_j-1, with x from -1 at the start of the span to 1 at its end.
#include "measure/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/text.hpp"

namespace toliman::measure {

namespace {

const std::string kOffset = "offset "; // and the name of the instrument
constexpr size_t kMostName = 56;

constexpr double kLargest = 1e100; // |t|, |y|, sigma: squares of their differences do not overflow

void check_lengths(const Series &series) {
    const size_t n = series.count();
    const std::pair<const char *, size_t> lengths[] = {{"y", series.y.size()},
                                                       {"sigma", series.sigma.empty() ? n : series.sigma.size()}};
    for (const auto &[name, length] : lengths)
        if (length != n)
            fail(Status::internal, "%s: %zu values of %zu samples", name, length, n);
}

constexpr std::pair<const char *, std::vector<double> Series::*> kMembers[] = {
    {"t", &Series::t},
    {"y", &Series::y},
    {"sigma", &Series::sigma},
    {"position_angle_deg", &Series::position_angle_deg},
    {"separation_arcsec", &Series::separation_arcsec},
    {"factor", &Series::factor},
    {"geometric_arcsec", &Series::geometric_arcsec}};

// Names of values that no column may have.
bool is_reserved(const std::string &name) {
    for (const auto &[known, member] : kMembers)
        if (name == known)
            return true;
    return name == "instrument" || (name.size() == 2 && name[0] == 'T' && name[1] >= '1' && name[1] < '1' + kMostTrend);
}

int64_t middle_of(const sky::Exposure &exposure) noexcept {
    const int64_t start = exposure.intervals.front().start_ns, end = exposure.intervals.back().end_ns;
    return start / 2 + end / 2 + (start % 2 + end % 2) / 2; // their difference may not fit in 64 bits
}

void check_number(const char *name, size_t sample, double value, bool is_positive) {
    if (!(std::fabs(value) <= kLargest) || (is_positive && !(value > 0)))
        fail(Status::argument, "{%s[%zu]} = %g: must be %s and at most 1e100", name, sample, value,
             is_positive ? "above 0" : "finite");
}

// Each instrument has a name of its own and at least one sample.
void check_instruments(const std::vector<std::string> &names, const std::vector<int32_t> &of_samples, size_t count) {
    if (names.empty() != of_samples.empty() || (!names.empty() && of_samples.size() != count))
        fail(Status::argument, "{instrument}: has %zu samples: must have %zu", of_samples.size(), count);
    std::vector<size_t> samples(names.size());
    for (size_t i = 0; i < of_samples.size(); i++) {
        if (of_samples[i] < 0 || static_cast<size_t>(of_samples[i]) >= names.size())
            fail(Status::argument, "{instrument[%zu]} = %d: must be in [0, %zu), the number of instruments", i,
                 of_samples[i], names.size());
        samples[static_cast<size_t>(of_samples[i])]++;
    }
    for (size_t k = 0; k < names.size(); k++) {
        if (names[k].empty() || names[k].size() > kMostName || std::count(names.begin(), names.end(), names[k]) > 1)
            fail(Status::argument, "{names}: \"%.64s\": must be a name of up to %zu characters, once", names[k].c_str(),
                 kMostName);
        if (samples[k] == 0)
            fail(Status::argument, "{instrument}: no sample of %.64s", names[k].c_str());
    }
}

void remove_offsets(Series &series) {
    const auto is_offset = [&](const Column &column) {
        for (size_t k = 1; k < series.instruments.size(); k++)
            if (column.name == kOffset + series.instruments[k])
                return true;
        return false;
    };
    series.columns.erase(std::remove_if(series.columns.begin(), series.columns.end(), is_offset), series.columns.end());
}

// The offset of an instrument from the first one is the coefficient of a column that is 1 in its samples and 0 in all
// others.
void add_offsets(Series &series) {
    for (size_t k = 1; k < series.instruments.size(); k++) {
        Column column = {kOffset + series.instruments[k], std::vector<double>(series.count(), 0.0), 1};
        for (size_t i = 0; i < series.count(); i++)
            column.values[i] = static_cast<size_t>(series.instrument[i]) == k ? 1 : 0;
        series.columns.push_back(std::move(column));
    }
}

} // namespace

std::string Series::function_name(size_t function) const {
    const auto order = static_cast<size_t>(trend.order);
    return function < order ? "T" + std::to_string(function + 1) : columns[function - order].name;
}

double Series::precision(size_t function) const {
    const auto order = static_cast<size_t>(trend.order);
    return function < order ? trend.precision[function] : columns[function - order].precision;
}

double &Series::precision(size_t function) {
    const auto order = static_cast<size_t>(trend.order);
    return function < order ? trend.precision[function] : columns[function - order].precision;
}

bool Series::has_priors() const noexcept {
    for (size_t f = 0; f < functions(); f++)
        if (precision(f) > 0)
            return true;
    return false;
}

std::vector<double> Series::column_rows() const {
    std::vector<double> rows;
    rows.reserve(count() * columns.size());
    for (size_t i = 0; i < count(); i++)
        for (const Column &column : columns)
            rows.push_back(column.values[i]);
    return rows;
}

std::vector<double> Series::function_rows() const {
    std::vector<double> rows;
    rows.reserve(count() * functions());
    for (size_t i = 0; i < count(); i++) {
        const double x = (2 * t[i] - trend.start - trend.end) / (trend.end - trend.start);
        double before = 1, now = x;
        for (int32_t j = 1; j <= trend.order; j++) {
            rows.push_back(now);
            before = std::exchange(now, 2 * x * now - before);
        }
        for (const Column &column : columns)
            rows.push_back(column.values[i]);
    }
    return rows;
}

void Series::set_trend(int32_t order, double start, double end) {
    if (start == 0 && end == 0 && order > 0 && !t.empty()) {
        const auto [first, last] = std::minmax_element(t.begin(), t.end());
        start = *first;
        end = *last;
    }
    if (order > 0 && !(start < end))
        fail(Status::argument, "{trend}: its span is from %g to %g: must be of different times, in this order", start,
             end);
    trend = {order, start, end, std::vector<double>(static_cast<size_t>(order), 0.0)};
}

size_t Series::offset_column(size_t which) const {
    const std::string wanted = kOffset + instruments[which];
    const auto has_name = [&](const Column &column) { return column.name == wanted; };
    return static_cast<size_t>(std::find_if(columns.begin(), columns.end(), has_name) - columns.begin());
}

void Series::set_instruments(std::vector<std::string> names, std::vector<int32_t> of_samples) {
    check_instruments(names, of_samples, count());
    remove_offsets(*this);
    instruments = std::move(names);
    instrument = std::move(of_samples);
    instrument_names.clear();
    for (const std::string &one : instruments)
        instrument_names += (instrument_names.empty() ? "" : ",") + one;
    add_offsets(*this);
}

void Series::add_column(const std::string &called, std::vector<double> values, double precision) {
    if (is_reserved(called))
        fail(Status::argument, "{name} = \"%.64s\": is a name of the series itself, or of a polynomial",
             called.c_str());
    for (size_t f = 0; f < functions(); f++)
        if (function_name(f) == called)
            fail(Status::argument, "{name} = \"%.64s\": is the name of another function", called.c_str());
    if (called.empty() || called.size() > 63 || functions() >= kMostFunctions)
        fail(Status::argument, "{name} = \"%.64s\": must be a name of up to 63 characters, of at most %zu functions",
             called.c_str(), kMostFunctions);
    Column column = {called, std::move(values), 0, precision, 1};
    for (size_t i = 0; i < column.values.size(); i++) {
        if (!(std::fabs(column.values[i]) <= 1e98))
            fail(Status::argument, "{values[%zu]} = %g: must be in [-1e98, 1e98]", i, column.values[i]);
        column.bound = std::max(column.bound, std::fabs(column.values[i]));
    }
    columns.push_back(std::move(column));
}

void Series::set_exposures(double exposure_s) {
    if (exposure_s == 0 && (kind != Kind::separation || !dates))
        return;
    const int64_t length = std::llround(exposure_s * 1e9);
    for (const int64_t middle : tai_of(*this)) {
        const int64_t start = middle - length / 2;
        exposures.push_back({{{start, start + length}}, false});
    }
}

void Series::set_plain_times(std::vector<double> times) {
    t = std::move(times);
    tai_ns.clear();
    dates.reset();
    trend = {};
}

void Series::set_times_of_exposures() {
    dates = Dates{ingest::TimeFormat::mjd, ingest::Scale::tai};
    for (const sky::Exposure &exposure : exposures) {
        tai_ns.push_back(middle_of(exposure));
        t.push_back(mjd_of(tai_ns.back()));
    }
}

std::vector<double> Series::values(const std::string &called) const {
    for (const auto &[known, member] : kMembers)
        if (called == known && !(this->*member).empty())
            return this->*member;
    if (called == "instrument" && !instrument.empty())
        return {instrument.begin(), instrument.end()};
    std::vector<double> found;
    for (size_t f = 0; f < functions(); f++)
        if (called == function_name(f)) {
            const std::vector<double> rows = function_rows();
            for (size_t i = f; i < rows.size(); i += functions())
                found.push_back(rows[i]);
            return found;
        }
    fail(Status::not_found, "{name} = \"%.64s\": the series does not have it", called.c_str());
}

void Series::add(const Series &from, size_t sample) {
    const auto append = [sample](const std::vector<double> &values, std::vector<double> &to) {
        if (!values.empty())
            to.push_back(values[sample]);
    };
    append(from.t, t);
    append(from.y, y);
    append(from.sigma, sigma);
    append(from.position_angle_deg, position_angle_deg);
    if (!from.tai_ns.empty())
        tai_ns.push_back(from.tai_ns[sample]);
    if (!from.exposures.empty())
        exposures.push_back(from.exposures[sample]);
    if (!from.instrument.empty())
        instrument.push_back(from.instrument[sample]);
    for (size_t c = 0; c < columns.size(); c++)
        append(from.columns[c].values, columns[c].values);
}

double known_unit(double unit, Kind kind) {
    if (!(unit >= 0 && unit <= 1e100))
        fail(Status::argument, "{unit} = %g: must be in (0, 1e100], or 0", unit);
    return unit == 0 && kind == Kind::separation ? 1 : unit;
}

void check(const Series &series) {
    check_lengths(series);
    for (size_t i = 0; i < series.count(); i++) {
        check_number("t", i, series.t[i], false);
        check_number("y", i, series.y[i], series.kind == Kind::separation);
        if (!series.sigma.empty())
            check_number("sigma", i, series.sigma[i], true);
        if (!series.position_angle_deg.empty())
            check_number("position_angle_deg", i, series.position_angle_deg[i], false);
    }
    for (const Column &column : series.columns)
        for (size_t i = 0; i < series.count(); i++)
            check_number(column.name.c_str(), i, column.values[i], false);
    if (series.functions() > kMostFunctions)
        fail(Status::argument, "{functions}: trend of order %d and %zu columns: must be at most %zu together",
             series.trend.order, series.columns.size(), kMostFunctions);
}

uint64_t digest_of(const Series &series, uint64_t hash) {
    for (const std::vector<double> &values :
         {series.t, series.y, series.sigma, series.position_angle_deg, series.function_rows()})
        hash = fnv1a(values, hash);
    for (size_t f = 0; f < series.functions(); f++)
        hash = fnv1a(std::array<double, 1>{series.precision(f)}, hash);
    return hash;
}

void check_reduced(const Series &series) {
    if (series.kind == Kind::separation)
        fail(Status::argument, "{series}: is of measured separations: reduce them by toliman_sky_reduce");
}

double mjd_of(int64_t tai_ns) noexcept {
    constexpr int64_t kDay = 86400000000000, kMjdOf1970 = 40587;
    const int64_t days = tai_ns / kDay;
    return static_cast<double>(kMjdOf1970 + days) +
           static_cast<double>(tai_ns - days * kDay) / static_cast<double>(kDay);
}

// By the parser of texts, whose dates have 128 bits.
std::vector<int64_t> tai_of(const Series &series) {
    if (!series.tai_ns.empty())
        return series.tai_ns;
    if (!series.dates)
        fail(Status::argument, "{t}: the times are plain numbers: must be dates, Modified Julian Days or Julian Days");
    std::vector<int64_t> times;
    times.reserve(series.count());
    const ingest::LeapSeconds none({});
    for (const double t : series.t) {
        char text[40];
        print_text(text, sizeof text, "%.17g", t);
        times.push_back(ingest::parse_time(text, ingest::TimeFormat::mjd, series.dates->scale, none));
    }
    return times;
}

} // namespace toliman::measure
