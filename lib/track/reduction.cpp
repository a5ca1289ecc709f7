// Method: value = measured / factor - geometric, in px. The factor is the ratio of the apparent to the geometric
// separation at the same times. Dividing by it, instead of subtracting a predicted apparent separation, leaves only
// 1e-4 of an error of the reference orbit with the period of a year, and needs no plate scale to do so. The ends of an
// interval are converted to TAI one by one: a clock that is fast by 1e-5 shifts the end of a day by 0.9 s.
#include "track/reduction.hpp"

#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace toliman::track {

namespace {

constexpr double kNsPerSecond = 1e9, kFarthest = 4e18; // ns

uint64_t &cell(Cells &cells, OwnColumn column, size_t further = 0) noexcept {
    return cells[static_cast<size_t>(column) + further];
}

} // namespace

Reducer::Reducer(const Columns &columns, const Reference &reference, OrbitErrors errors, const std::string &ledger)
    : measured_(columns.find(kMeasured)), factor_(columns.find(name_of(OwnColumn::factor))),
      geometric_(columns.find(name_of(OwnColumn::geometric_arcsec))),
      partials_(columns.find(name_of(OwnColumn::partials))), scale_arcsec_(reference.scale_arcsec), errors_(errors) {
    if (measured_ == columns.count())
        fail(Status::mismatch, "{%s}: has no column %s: a system needs a fit, or an estimator with this value",
             ledger.c_str(), kMeasured);
    if (factor_ == columns.count() || geometric_ == columns.count() || partials_ + kPartials > columns.count())
        fail(Status::mismatch, "{%s}: its frames are not reduced: rebuild the folder with the system", ledger.c_str());
}

double Reducer::value(const Record &record) const noexcept {
    const auto number = [&](size_t column) { return with_bits<double>(record.cells[column]); };
    return number(measured_) / number(factor_) - number(geometric_) / scale_arcsec_;
}

Row Reducer::row(const Record &record) const noexcept {
    Row row = {};
    size_t column = 0;
    for (size_t i = 0; i < kPartials; i++)
        if (errors_.sigmas[i] > 0)
            row[column++] = with_bits<double>(record.cells[partials_ + i]);
    return row;
}

void store(const Reduction *reduction, Cells &cells) noexcept {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const auto set = [&](OwnColumn column, double number) { cell(cells, column) = with_bits<uint64_t>(number); };
    set(OwnColumn::factor, reduction != nullptr ? reduction->factor : kNone);
    set(OwnColumn::geometric_arcsec, reduction != nullptr ? reduction->geometric_arcsec : kNone);
    for (size_t i = 0; i < kPartials; i++)
        cell(cells, OwnColumn::partials, i) =
            with_bits<uint64_t>(reduction != nullptr ? reduction->partials[i] : kNone);
}

namespace {

void empty_cell(const Columns &columns, OwnColumn own, Record &record) noexcept {
    const size_t column = columns.find(name_of(own));
    if (column < columns.count())
        record.cells[column] = columns.all()[column].empty();
}

} // namespace

void forget_reduction(const Columns &columns, Record &record) noexcept {
    empty_cell(columns, OwnColumn::factor, record);
    empty_cell(columns, OwnColumn::geometric_arcsec, record);
    record.reason = record.kind == Kind::accepted ? Reason::no_orbit : record.reason;
}

void clear_reduction(const Columns &columns, Record &record) noexcept {
    empty_cell(columns, OwnColumn::intervals, record);
    forget_reduction(columns, record);
}

bool find_on_target(int64_t camera_ns, double exposure_s, const double *intervals, size_t count, const Clock &clock,
                    OnTarget &on_target) {
    const double whole[] = {0, exposure_s};
    on_target.listed = count > 0;
    on_target.spans.clear();
    const double *const pairs = on_target.listed ? intervals : whole;
    for (size_t i = 0; i < (on_target.listed ? count : 1); i++) {
        int64_t tai_ns[2];
        for (size_t end = 0; end < 2; end++) {
            const double offset = (pairs[2 * i + end] - exposure_s / 2) * kNsPerSecond;
            int64_t camera_end = 0;
            if (!(std::fabs(offset) <= kFarthest) ||
                __builtin_add_overflow(camera_ns, std::llround(offset), &camera_end))
                return false;
            const std::optional<int64_t> tai = clock.tai_ns(camera_end);
            if (!tai)
                return false;
            tai_ns[end] = *tai;
        }
        on_target.spans.push_back({tai_ns[0], tai_ns[1]});
    }
    return true;
}

} // namespace toliman::track
