#include "measure/folder.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/robust.hpp"
#include "measure/reduction.hpp"
#include "scene/system.hpp"
#include "sky/columns.hpp"

namespace toliman::measure {

namespace {

constexpr double kNsPerDay = 86400e9;
constexpr double kRounding = 1e-10; // days, of a Modified Julian Day

double number(const track::Columns &columns, size_t column, const track::Record &record) noexcept {
    return columns.all()[column].number(record.cells[column]);
}

// Columns of the sums: the partial derivatives by the elements whose errors are fitted.
void add_columns(const track::Tracker &tracker, const period::Basis &basis, Series &series,
                 std::vector<size_t> &places) {
    const track::Plan &plan = tracker.plan();
    const size_t first = tracker.columns().find(name_of(track::OwnColumn::partials));
    for (size_t i = 0, c = 0; i < track::kPartials; i++) {
        if (!(plan.errors.sigmas[i] > 0) || c >= static_cast<size_t>(basis.columns))
            continue;
        series.columns.push_back({sky::element_name(i),
                                  {},
                                  basis.bound[c],
                                  basis.precision[basis.first_column() + c],
                                  plan.reference.scale_arcsec});
        places.push_back(first + i);
        c++;
    }
}

// Position angles on the orbit do not depend on the observer: the light time within the orbit of the Earth changes them
// by 1e-4 deg.
void set_system(const track::Reference &reference, Series &series) {
    if (!reference.is_given())
        return;
    const sky::System system = read_system(reference.system, "system");
    const sky::Predictor predictor(system, {});
    for (const int64_t time : series.tai_ns)
        series.position_angle_deg.push_back(predictor.at(time).geometric_angle_deg);
    set_stars(system, series.tai_ns, series);
}

bool is_measured(track::Verdict verdict) noexcept {
    return verdict == track::Verdict::accepted || verdict == track::Verdict::unreduced;
}

sky::Exposure exposure_of(const track::OnTarget &on_target) {
    sky::Exposure exposure = {{}, on_target.listed};
    for (const track::Span &span : on_target.spans)
        exposure.intervals.push_back({span.start_ns, span.end_ns});
    return exposure;
}

} // namespace

namespace {

// The trend of the sums, which is of dates. Polynomials without priors are the same over any span: over that of the
// samples they are independent, over that of a long mission, of which these are a small part, they are nearly alike.
void add_trend(const period::Grid &grid, Series &series) {
    const auto priors = grid.basis.precision.begin() + 1;
    const bool is_free = std::all_of(priors, priors + grid.basis.trend, [](double prior) { return prior == 0; });
    const auto date = [&](double t) {
        return mjd_of(grid.time_offset_ns) + t * (static_cast<double>(grid.unit_ns) / kNsPerDay);
    };
    const auto [first, last] = std::minmax_element(series.t.begin(), series.t.end());
    if (is_free && *first < *last) {
        series.set_trend(grid.basis.trend, 0, 0);
        return;
    }
    const auto rounded = [](double end, double t) { return std::fabs(end - t) < kRounding ? t : end; };
    series.set_trend(grid.basis.trend, rounded(date(grid.basis.start), *first), rounded(date(grid.basis.end), *last));
}

// Times, and trend, as the sums have them.
void use_grid_times(const period::Grid &grid, Series &series) {
    const auto offset_ns = static_cast<long double>(grid.time_offset_ns);
    for (size_t i = 0; i < series.count(); i++)
        series.t[i] = static_cast<double>((static_cast<long double>(series.tai_ns[i]) - offset_ns) /
                                          static_cast<long double>(grid.unit_ns));
    series.dates.reset();
    series.time_unit_days = static_cast<double>(grid.unit_ns) / kNsPerDay;
    series.trend = {grid.basis.trend, grid.basis.start, grid.basis.end, {}};
}

} // namespace

Series values_of(const track::Tracker &tracker, const period::Grid &grid, bool plain) {
    const track::Columns &columns = tracker.columns();
    const track::Reference &reference = tracker.plan().reference;
    const size_t chi_square = columns.find(name_of(track::OwnColumn::chi_square));
    Series series;
    series.kind = reference.is_given() ? Kind::reduced : Kind::value;
    series.dates = Dates{ingest::TimeFormat::mjd, ingest::Scale::tai};
    series.unit = reference.scale_arcsec;
    std::vector<size_t> places;
    add_columns(tracker, grid.basis, series, places);
    std::vector<double> chi_squares;
    tracker.visit(0, tracker.records(), [&](const track::Record &record, const track::Outcome &outcome) {
        if (outcome.verdict != track::Verdict::accepted)
            return;
        series.tai_ns.push_back(outcome.tai_ns);
        series.t.push_back(mjd_of(outcome.tai_ns));
        series.y.push_back(outcome.value);
        series.sigma.push_back(record.sigma);
        for (size_t c = 0; c < places.size(); c++)
            series.columns[c].values.push_back(number(columns, places[c], record));
        if (chi_square < columns.count() && number(columns, chi_square, record) > 0)
            chi_squares.push_back(number(columns, chi_square, record));
    });
    if (series.t.empty())
        fail(Status::not_found, "has no accepted frame");
    series.frame_chi_square = median(std::move(chi_squares));
    set_system(reference, series);
    if (plain)
        use_grid_times(grid, series);
    else if (grid.basis.trend > 0)
        add_trend(grid, series);
    const auto priors = grid.basis.precision.begin() + 1;
    series.trend.precision.assign(priors, priors + series.trend.order);
    return series;
}

namespace {

// What the frames of a tracker have in the columns of its ledger.
class Frames {
  public:
    explicit Frames(const track::Tracker &tracker)
        : tracker_(tracker), separation_(find(track::kMeasured)),
          exposure_(find(name_of(track::OwnColumn::exposure_s))), shift_(find(name_of(track::OwnColumn::shift_s))),
          listed_(find(name_of(track::OwnColumn::intervals))) {
        if (!has(separation_) || !has(exposure_))
            fail(Status::not_found, "has no column %s: must have frames measured by a fit", track::kMeasured);
    }

    // Not a number, 0 or negative where the fit failed.
    double separation(const track::Record &record) const noexcept { return number(columns(), separation_, record); }

    // None if the time on target is not known. place: number of the record.
    std::optional<sky::Exposure> exposure(const track::Record &record, const track::Outcome &outcome,
                                          uint64_t place) const {
        const double own_s = number(columns(), exposure_, record),
                     listed = has(listed_) ? number(columns(), listed_, record) : 0;
        // Without the column, frames that came with intervals are those whose middle was shifted.
        const bool is_lost = listed < 0 || (!has(listed_) && has(shift_) && number(columns(), shift_, record) != 0);
        if (is_lost || outcome.flaw.reason == track::Reason::no_intervals)
            return std::nullopt;
        std::vector<double> intervals;
        if (listed > 0 && !read(place, intervals))
            return std::nullopt;
        track::OnTarget on_target;
        if (!find_on_target(record.camera_ns, own_s > 0 ? own_s : tracker_.plan().timing.exposure_s, intervals.data(),
                            intervals.size() / 2, tracker_.plan().clock, on_target))
            return std::nullopt;
        return exposure_of(on_target);
    }

  private:
    const track::Columns &columns() const noexcept { return tracker_.columns(); }
    size_t find(const char *name) const noexcept { return columns().find(name); }
    bool has(size_t column) const noexcept { return column < columns().count(); }

    // False if their records are damaged, or were not kept, as by a tracker in memory.
    bool read(uint64_t place, std::vector<double> &intervals) const {
        try {
            intervals = tracker_.intervals_of(place);
            return true;
        } catch (const Error &error) {
            if (error.status() != Status::lost && error.status() != Status::state)
                throw;
            return false;
        }
    }

    const track::Tracker &tracker_;
    size_t separation_, exposure_, shift_, listed_;
};

} // namespace

Series separations_of(const track::Tracker &tracker) {
    const Frames frames(tracker);
    Series series;
    series.kind = Kind::separation;
    series.dates = Dates{ingest::TimeFormat::mjd, ingest::Scale::tai};
    series.unit = tracker.plan().reference.scale_arcsec;
    std::vector<double> chi_squares;
    uint64_t place = 0;
    tracker.visit(0, tracker.records(), [&](const track::Record &record, const track::Outcome &outcome) {
        const uint64_t at = place++;
        if (!is_measured(outcome.verdict))
            return;
        std::optional<sky::Exposure> exposure = frames.exposure(record, outcome, at);
        const double separation = frames.separation(record);
        if (!exposure || !(separation > 0 && std::isfinite(separation))) {
            series.left_out++;
            return;
        }
        series.tai_ns.push_back(outcome.tai_ns);
        series.t.push_back(mjd_of(outcome.tai_ns));
        series.y.push_back(separation);
        series.sigma.push_back(record.sigma);
        series.exposures.push_back(std::move(*exposure));
        if (outcome.goodness.chi_square > 0)
            chi_squares.push_back(outcome.goodness.chi_square);
    });
    if (series.t.empty())
        fail(Status::not_found, "has no accepted or unreduced frame whose time on target is known");
    series.frame_chi_square = median(std::move(chi_squares));
    return series;
}

} // namespace toliman::measure
