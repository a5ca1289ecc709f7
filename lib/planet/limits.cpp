// Method: for one additional planet on a circular orbit of each period, two amplitudes: the upper limit that the series
// sets (detection.cpp), and the smallest that a search of these times and errors detects with the probability
// (recovery.cpp). Masses follow from both by Kepler's third law with e = 0 (mass.cpp).
#include "planet/limits.hpp"

#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::planet {

namespace {

void check_period(const Result &result, const char *name, double period) {
    const Settings &settings = result.settings;
    if (!(period >= settings.period_min * (1 - 1e-12) && period <= settings.period_max * (1 + 1e-12)))
        fail(Status::argument, "{%s} = %.9g: must be in the prior, %.9g to %.9g", name, period, settings.period_min,
             settings.period_max);
}

} // namespace

std::vector<Limit> limits_of(const Result &result, const Recovery &recovery, const std::vector<double> &periods,
                             double probability) {
    const Units &units = result.settings.units;
    for (const double period : periods)
        check_period(result, "periods", period);
    std::vector<Limit> limits(periods.size());
    run_jobs(worker_count(result.settings.threads), periods.size(), [&](size_t i) {
        const double period = periods[i];
        const double upper = recovery.detection().upper(1 / period, probability);
        const double detectable = recovery.recoverable(1 / period, probability);
        limits[i] = {period,
                     upper,
                     detectable,
                     units.mass(0, period, 0, upper),
                     units.mass(1, period, 0, upper),
                     units.mass(0, period, 0, detectable),
                     units.mass(1, period, 0, detectable)};
    });
    return limits;
}

void check(const Result &result, const InjectionCell &cell) {
    check_period(result, "period_min", cell.period_min);
    check_period(result, "period_max", cell.period_max);
    if (cell.period_min > cell.period_max)
        fail(Status::argument, "{period_min} = %.9g: must be at most period_max = %.9g", cell.period_min,
             cell.period_max);
    if (!(cell.size_min > 0 && cell.size_min <= cell.size_max && cell.size_max <= 1e100))
        fail(Status::argument, "{size_min} = %g, size_max = %g: must be above 0, in this order", cell.size_min,
             cell.size_max);
    if (cell.star < -1 || cell.star > 1)
        fail(Status::argument, "{star} = %d: must be -1, 0 or 1", cell.star);
    if (cell.star >= 0 && !result.settings.units.knows_mass(cell.star))
        fail(Status::argument, "{star} = %d: unit, parallax or mass of the star is unknown", cell.star);
}

} // namespace toliman::planet
