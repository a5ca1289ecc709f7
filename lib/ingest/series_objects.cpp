// Samples of JSON objects: {"t": 1, "y": 2, "sigma": 0.1}; other keys are ignored, and null is a missing value.
#include "ingest/series.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/fields.hpp"
#include "ingest/series_values.hpp"

namespace toliman::ingest {

namespace {

using Kind = json::Value::Kind;

json::Value object_of(const std::string &line) {
    try {
        return json::parse(line, "is not a JSON object", json::Form::line);
    } catch (const Error &error) {
        fail(error.status(), "%s", error.what()); // without the field, which is not a name
    }
}

std::string text_of(const json::Value &value) {
    char digits[32];
    print_text(digits, sizeof digits, "%.17g", value.number);
    return value.kind == Kind::number ? digits : value.text;
}

double number_in(const std::string &name, const json::Value &value, size_t column) {
    if (value.kind != Kind::number)
        fail(Status::format, "{%s}: must be a number", name.c_str());
    if (const char *const flaw = flaw_of(value.number, column))
        fail(Status::format, "{%s} = %g: %s", name.c_str(), value.number, flaw);
    return value.number;
}

} // namespace

std::optional<Sample> Series::parse_object(const std::string &line) {
    if (known_ && !objects_)
        fail(Status::format, "is a JSON object: the lines before are not");
    const json::Value object = object_of(line);
    use_keys(object);
    const auto value_at = [&](size_t place) -> const json::Value & { return object.items[place]; };
    const bool has_sigma = places_.sigma != kNoPlace;
    if (value_at(places_.t).kind == Kind::null || value_at(places_.y).kind == Kind::null ||
        (has_sigma && value_at(places_.sigma).kind == Kind::null)) {
        objects_ = known_ = true;
        missing_++;
        return std::nullopt;
    }
    std::string warning;
    const double t = time_of(names_[places_.t], value_at(places_.t), warning);
    const double y = number_in(names_[places_.y], value_at(places_.y), 1);
    const double sigma = has_sigma ? number_in(names_[places_.sigma], value_at(places_.sigma), 2) : 0;
    std::vector<std::string> fields;
    for (const json::Value &value : object.items)
        fields.push_back(text_of(value));
    const Sample sample = sample_of(t, y, sigma, instrument_ != kNoPlace ? &fields[instrument_] : nullptr);
    see_instruments(names_, fields);
    if (!warning.empty())
        warn(warning);
    objects_ = true;
    return sample;
}

// The places of t, y and sigma among the keys, which usually are those of the object before.
void Series::use_keys(const json::Value &object) {
    if (object.names == names_ && objects_)
        return;
    const Places places = places_of(options_.columns, object.names);
    const size_t found[kSeriesMost] = {places.t, places.y, places.sigma};
    for (size_t i = 0; i < (options_.columns.empty() ? kSeriesFewest : options_.columns.size()); i++)
        if (found[i] == kNoPlace)
            fail(Status::format, "{%s}: must be a number", wanted_name(i).c_str());
    if (objects_ && (places.sigma == kNoPlace) != (places_.sigma == kNoPlace))
        fail(Status::format, "has other keys than the lines before: either all or none must have sigma");
    if (objects_ && (object.names[places.t] != names_[places_.t] || object.names[places.y] != names_[places_.y]))
        fail(Status::format, "has other keys than the lines before: must have {%s} and %s", names_[places_.t].c_str(),
             names_[places_.y].c_str());
    names_ = object.names;
    places_ = places;
    use_instrument();
    if (begun_)
        return;
    std::vector<TableColumn> columns;
    for (const std::string &name : names_)
        columns.push_back({name, split_unit(name).unit, "", 0, 0, -1, false});
    use_units(columns);
}

// The time of an object is a number, or a string with a date or a day.
double Series::time_of(const std::string &name, const json::Value &value, std::string &warning) {
    if (value.kind != Kind::number && value.kind != Kind::text)
        fail(Status::format, "{%s}: must be a number", name.c_str());
    const std::string text = text_of(value);
    warning = times_.use_first(text);
    if (times_.format())
        return times_.day_of(text);
    return number_in(name, value, 0);
}

} // namespace toliman::ingest
