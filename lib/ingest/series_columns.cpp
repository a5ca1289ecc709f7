// The columns of a series: from a line of names, a comment, or by position.
#include "ingest/series.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "ingest/fields.hpp"
#include "ingest/series_values.hpp"

namespace toliman::ingest {

namespace {

// Status::mismatch if a column that is needed does not exist.
void check_places(const Places &places, const std::vector<std::string> &wanted, const std::vector<std::string> &names) {
    const size_t found[kSeriesMost] = {places.t, places.y, places.sigma};
    for (size_t i = 0; i < (wanted.empty() ? kSeriesFewest : wanted.size()); i++)
        if (found[i] == kNoPlace)
            fail(Status::mismatch, "has no column {%s} among %s",
                 wanted.empty() ? kSeriesColumns[i] : wanted[i].c_str(), joined(names).c_str());
}

} // namespace

std::string Series::wanted_name(size_t column) const {
    return options_.columns.empty() ? kSeriesColumns[column] : options_.columns[column];
}

void Series::use_names() {
    names_ = header_.names();
    places_ = places_of(options_.columns, names_);
    check_places(places_, options_.columns, names_);
    use_instrument();
    known_ = true;
    if (const std::string likely = likely_sigma(names_, places_);
        options_.columns.empty() && places_.sigma == kNoPlace && !likely.empty())
        warn("no column is known to be sigma: column " + likely + " is not used");
}

void Series::use_instrument() {
    if (options_.instrument.empty())
        return;
    instrument_ = place_of(options_.instrument, names_);
    if (instrument_ == kNoPlace)
        fail(Status::mismatch, "has no column {%s} among %s", options_.instrument.c_str(), joined(names_).c_str());
}

// The columns of a first row of a table without a line of names.
void Series::use_columns(size_t width) {
    const std::vector<std::string> &wanted = options_.columns;
    const bool by_number = !wanted.empty() && std::all_of(wanted.begin(), wanted.end(), column_number);
    const auto is_useful = [&](const std::vector<std::string> &names) {
        const auto is_there = [&](const std::string &name) { return place_of(name, names) != kNoPlace; };
        return wanted.empty() || by_number ? name_a_series(names) : std::all_of(wanted.begin(), wanted.end(), is_there);
    };
    header_.name_by_comments(width, is_useful);
    names_ = header_.names();
    const bool named = width > 0 && std::any_of(names_.begin(), names_.end(), [](const auto &n) { return !n.empty(); });
    if (!wanted.empty() && !by_number && !named)
        fail(Status::mismatch, "has no column names: the first line must name %s", joined(wanted).c_str());
    if (width < kSeriesFewest)
        fail(Status::format,
             "has %zu %s, separated by %s: must be t,y or t,y,sigma, or the first line must name the columns", width,
             width == 1 ? "column" : "columns", separator_name(header_.separator()));
    if (options_.growing && !named && wanted.empty() && width > kSeriesMost) // the first line may be damaged
        fail(Status::format, "has %zu columns without names: must be t,y or t,y,sigma, or the columns must be named",
             width);
    places_ = named || by_number ? places_of(wanted, names_) : Places{0, 1, width > 2 ? 2 : kNoPlace};
    if (places_.t == 0 && places_.y == 1 && wanted.empty() && width == kSeriesMost)
        places_.sigma = 2; // also by a name that is not known
    for (size_t i = 0; i < wanted.size(); i++)
        if (by_number && column_number(wanted[i]) > width)
            fail(Status::mismatch, "has no column {%s}: has %zu columns", wanted[i].c_str(), width);
    use_instrument();
    if (!named && wanted.empty() && width > kSeriesMost)
        warn("the columns have no names: columns 1, 2 and 3 of " + std::to_string(width) +
             " are taken as t, y and sigma");
}

void Series::use_units(const std::vector<TableColumn> &columns) {
    times_.use_column(columns[places_.t].name, unit_of(columns[places_.t].unit));
    unit_ = unit_of(columns[places_.y].unit);
    if (places_.sigma == kNoPlace)
        return;
    const Unit unit = unit_of(columns[places_.sigma].unit);
    sigma_factor_ = factor_between(unit, unit_);
    if (sigma_factor_ == 0)
        fail(Status::mismatch, "{%s}: its unit is %s: cannot be converted to %s, the unit of %s",
             columns[places_.sigma].name.c_str(), unit.name.c_str(), unit_.name.c_str(),
             columns[places_.y].name.c_str());
}

} // namespace toliman::ingest
