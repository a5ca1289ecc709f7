#include "measure/folder.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "measure/reduction.hpp"
#include "scene/system.hpp"
#include "sky/columns.hpp"

namespace toliman::measure {

namespace {

constexpr double kNsPerDay = 86400e9;

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

double middle_of(std::vector<double> values) {
    if (values.empty())
        return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
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
    set_stars(system, series);
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

Series values_of(const track::Tracker &tracker, const period::Grid &grid) {
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
    series.frame_chi_square = middle_of(std::move(chi_squares));
    const auto date = [&](double t) {
        return mjd_of(grid.time_offset_ns) + t * (static_cast<double>(grid.unit_ns) / kNsPerDay);
    };
    if (grid.basis.trend > 0) {
        series.set_trend(grid.basis.trend, date(grid.basis.start), date(grid.basis.end));
        std::copy_n(grid.basis.precision.begin() + 1, series.trend.precision.size(), series.trend.precision.begin());
    }
    set_system(reference, series);
    return series;
}

Series separations_of(const track::Tracker &tracker) {
    const track::Columns &columns = tracker.columns();
    const track::Plan &plan = tracker.plan();
    const size_t separation = columns.find(track::kMeasured),
                 exposure = columns.find(name_of(track::OwnColumn::exposure_s)),
                 listed = columns.find(name_of(track::OwnColumn::intervals));
    if (separation == columns.count() || exposure == columns.count())
        fail(Status::not_found, "has no column %s: must have frames measured by a fit", track::kMeasured);
    Series series;
    series.kind = Kind::separation;
    series.dates = Dates{ingest::TimeFormat::mjd, ingest::Scale::tai};
    series.unit = plan.reference.scale_arcsec;
    uint64_t place = 0;
    tracker.visit(0, tracker.records(), [&](const track::Record &record, const track::Outcome &outcome) {
        const uint64_t at = place++;
        if (!is_measured(outcome.verdict))
            return;
        const double own_s = number(columns, exposure, record);
        std::vector<double> intervals;
        if (listed < columns.count() && number(columns, listed, record) > 0)
            intervals = tracker.intervals_of(at);
        const bool is_lost = listed < columns.count() && number(columns, listed, record) < 0;
        track::OnTarget on_target;
        const bool is_known = !is_lost && outcome.flaw.reason != track::Reason::no_intervals &&
                              find_on_target(record.camera_ns, own_s > 0 ? own_s : plan.timing.exposure_s,
                                             intervals.data(), intervals.size() / 2, plan.clock, on_target);
        if (!is_known) {
            series.left_out++;
            return;
        }
        series.tai_ns.push_back(record.tai_ns);
        series.t.push_back(mjd_of(record.tai_ns));
        series.y.push_back(number(columns, separation, record));
        series.sigma.push_back(record.sigma);
        series.exposures.push_back(exposure_of(on_target));
    });
    if (series.t.empty())
        fail(Status::not_found, "has no accepted or unreduced frame whose time on target is known");
    return series;
}

} // namespace toliman::measure
