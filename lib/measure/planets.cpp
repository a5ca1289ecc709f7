#include "measure/planets.hpp"

#include "base/error.hpp"

namespace toliman::measure {

namespace {

// Times of velocities in the unit and scale of a series.
std::vector<double> times_as(const Series &series, const Series &velocities, const char *name) {
    if (series.dates.has_value() != velocities.dates.has_value())
        fail(Status::argument, "{%s}: its times are %s: must be as those of the series", name,
             velocities.dates ? "dates" : "plain numbers");
    std::vector<double> times = velocities.t;
    if (!series.dates) {
        for (double &time : times)
            time *= velocities.time_unit_days / series.time_unit_days;
        return times;
    }
    const double offset = series.t.front() - mjd_of(tai_of(series).front()); // of the time scales
    const std::vector<int64_t> tai_ns = tai_of(velocities);
    for (size_t i = 0; i < times.size(); i++)
        times[i] = mjd_of(tai_ns[i]) + offset;
    return times;
}

} // namespace

planet::GivenSeries given_of(const Series &series, const char *name) {
    planet::GivenSeries given = {};
    given.t = series.t;
    given.y = series.y;
    given.sigma = series.sigma;
    given.rows = series.column_rows();
    given.position_angle_deg = series.position_angle_deg;
    given.trend = series.trend.order;
    given.columns = static_cast<int32_t>(series.columns.size());
    given.trend_start = series.trend.start;
    given.trend_end = series.trend.end;
    given.precision = {0}; // of the mean: no prior
    given.velocity = series.kind == Kind::velocity;
    given.frame_chi_square = series.frame_chi_square;
    given.instrument = series.instrument;
    given.offsets = {0}; // the first instrument has none
    given.name = name;
    for (size_t f = 0; f < series.functions(); f++)
        given.precision.push_back(series.precision(f));
    for (size_t k = 1; k < series.instruments.size(); k++)
        given.offsets.push_back(series.offset_column(k));
    return given;
}

void add_velocities(const Series &series, const planet::Units &units, const Series &own, size_t star, const char *name,
                    planet::GivenVelocities &velocities) {
    if (own.kind != Kind::velocity)
        fail(Status::argument, "{%s}: must be of kind TOLIMAN_MEASURE_VELOCITY", name);
    if (own.sigma.empty() || own.unit == 0)
        fail(Status::argument, "{%s}: must have sigmas and a known unit", name);
    if (series.kind == Kind::velocity || series.sigma.empty() || units.unit == 0 || units.parallax_arcsec == 0)
        fail(Status::argument, "{%s}: the series must be of separations, with sigmas and known unit and parallax",
             name);
    velocities.of[star] = given_of(own, name);
    velocities.of[star]->t = times_as(series, own, name);
    velocities.per_motion[star] = planet::velocity_of_motion(units) / own.unit;
}

void add_names(const Series &series, std::vector<std::string> &names) {
    if (series.instruments.empty())
        names.emplace_back();
    names.insert(names.end(), series.instruments.begin(), series.instruments.end());
}

} // namespace toliman::measure
