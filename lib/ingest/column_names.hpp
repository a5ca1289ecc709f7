// Names of columns: which is the time, the value, its standard deviation, and which instrument measured.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/time_scale.hpp"

namespace toliman::ingest {

constexpr size_t kNoPlace = SIZE_MAX;
constexpr int64_t kReducedJd = 2400000; // JD - RJD

// The name without a unit in brackets at its end, and the unit: "rv (m/s)" is "rv" and "m/s".
struct NameAndUnit {
    std::string name, unit;
};
NameAndUnit split_unit(const std::string &name);

// What the name of a column of times states.
struct TimeName {
    std::optional<TimeFormat> format; // empty: numbers of no known origin
    int64_t offset = 0;               // days to add to the numbers: 2450000 of "BJD - 2450000"
    std::optional<Scale> scale;       // of "bjd_tdb"
};
// Empty if a name, with its unit in brackets, is not one of a time.
std::optional<TimeName> time_name(std::string_view name);

// Places of t, y and sigma; kNoPlace for none.
struct Places {
    size_t t = kNoPlace, y = kNoPlace, sigma = kNoPlace;
};

// The place of the column that a caller names: by its name, with or without its unit, or by its number from 1.
// kNoPlace if there is none; Status::mismatch if there are several.
size_t place_of(const std::string &wanted, const std::vector<std::string> &names);
// The places of t, y and sigma by their usual names. Status::mismatch, naming them, if there are several for one.
Places usual_places(const std::vector<std::string> &names);
// Whether there are usual names of both t and y.
bool name_a_series(const std::vector<std::string> &names);
// The same for the names that the caller wants, or the usual ones if it names none.
Places places_of(const std::vector<std::string> &wanted, const std::vector<std::string> &names);

// A column other than `used` whose name suggests that it contains standard deviations; "" if there is none.
std::string likely_sigma(const std::vector<std::string> &names, const Places &used);
bool is_instrument(const std::string &name);
// The number that is the whole text, from 1; 0 for other texts.
size_t column_number(const std::string &text) noexcept;

} // namespace toliman::ingest
