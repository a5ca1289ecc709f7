// The series of a search for planets, as lib/planet takes it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "api/measure_handle.hpp"
#include "planet/mass.hpp"
#include "planet/series.hpp"

namespace toliman::api {

// The arrays of a series, as the search takes them. name: of the argument, in messages; t: the times.
class Given {
  public:
    Given(const measure::Series &series, const std::vector<double> &t, const char *name)
        : rows_(series.column_rows()), precision_(1 + series.functions()) {
        for (size_t f = 0; f < series.functions(); f++)
            precision_[1 + f] = series.precision(f);
        given_ = {series.count(),
                  t.data(),
                  series.y.data(),
                  or_null(series.sigma),
                  rows_.data(),
                  or_null(series.position_angle_deg),
                  series.trend.order,
                  static_cast<int32_t>(series.columns.size()),
                  series.trend.start,
                  series.trend.end,
                  precision_.data(),
                  series.kind == measure::Kind::velocity,
                  series.frame_chi_square,
                  series.instrument.empty() ? nullptr : series.instrument.data(),
                  {0},
                  name};
        for (size_t k = 1; k < series.instruments.size(); k++)
            given_.offsets.push_back(series.offset_column(k));
    }
    const planet::GivenSeries &get() const noexcept { return given_; }

  private:
    static const double *or_null(const std::vector<double> &values) noexcept {
        return values.empty() ? nullptr : values.data();
    }
    std::vector<double> rows_, precision_;
    planet::GivenSeries given_;
};

inline void check_series(const measure::Series &series, bool jitter) {
    if (series.kind == measure::Kind::separation)
        fail(Status::argument, "{series}: is of measured separations: reduce them by toliman_sky_reduce");
    if (series.sigma.empty() && !jitter)
        fail(Status::argument, "{series}: has no sigma: must have one with TOLIMAN_PLANET_NO_JITTER");
}

// Times of velocities in the unit and scale of a series.
inline std::vector<double> times_as(const measure::Series &series, const measure::Series &velocities,
                                    const char *name) {
    if (series.dates.has_value() != velocities.dates.has_value())
        fail(Status::argument, "{%s}: its times are %s: must be as those of the series", name,
             velocities.dates ? "dates" : "plain numbers");
    std::vector<double> times = velocities.t;
    if (!series.dates) {
        for (double &time : times)
            time *= velocities.time_unit_days / series.time_unit_days;
        return times;
    }
    const double offset = series.t.front() - measure::mjd_of(measure::tai_of(series).front()); // of the time scales
    const std::vector<int64_t> tai_ns = measure::tai_of(velocities);
    for (size_t i = 0; i < times.size(); i++)
        times[i] = measure::mjd_of(tai_ns[i]) + offset;
    return times;
}

// Velocities of both stars, in the times of a series.
class Velocities {
  public:
    Velocities(const measure::Series &series, const planet::Units &units, const toliman_measure *a,
               const toliman_measure *b) {
        add(series, units, a, 0, "options->velocity_a");
        add(series, units, b, 1, "options->velocity_b");
    }
    const planet::GivenVelocities &get() const noexcept { return given_; }
    const std::vector<std::string> &names() const noexcept { return names_; }

  private:
    void add(const measure::Series &series, const planet::Units &units, const toliman_measure *handle, size_t star,
             const char *name) {
        if (handle == nullptr)
            return;
        const Use use(handle, name);
        const measure::Series &own = use->series;
        if (own.kind != measure::Kind::velocity)
            fail(Status::argument, "{%s}: must be of kind TOLIMAN_MEASURE_VELOCITY", name);
        if (own.sigma.empty() || own.unit == 0)
            fail(Status::argument, "{%s}: must have sigmas and a known unit", name);
        if (series.kind == measure::Kind::velocity || series.sigma.empty() || units.unit == 0 ||
            units.parallax_arcsec == 0)
            fail(Status::argument, "{%s}: the series must be of separations, with sigmas and known unit and parallax",
                 name);
        times_[star] = times_as(series, own, name);
        arrays_[star] = std::make_unique<Given>(own, times_[star], name);
        given_.of[star] = &arrays_[star]->get();
        given_.per_motion[star] = planet::velocity_of_motion(units) / own.unit;
        add_names(own, names_);
    }

  public:
    static void add_names(const measure::Series &series, std::vector<std::string> &names) {
        if (series.instruments.empty())
            names.emplace_back();
        names.insert(names.end(), series.instruments.begin(), series.instruments.end());
    }

  private:
    std::vector<double> times_[2];
    std::unique_ptr<Given> arrays_[2];
    planet::GivenVelocities given_;
    std::vector<std::string> names_;
};

} // namespace toliman::api
