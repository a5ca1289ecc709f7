#include "api/sky_measurements.hpp"

#include <cmath>

#include "api/guard.hpp"

namespace toliman::api {

std::vector<sky::Interval> intervals_of(const int64_t *intervals, size_t count) {
    std::vector<sky::Interval> given(count);
    for (size_t i = 0; i < count; i++)
        given[i] = {intervals[2 * i], intervals[2 * i + 1]};
    return given;
}

sky::Exposure take_exposure(const int64_t *&next, const size_t *interval_counts, size_t i) {
    const size_t own = interval_counts != nullptr ? interval_counts[i] : 1;
    sky::Exposure taken = {intervals_of(next, own), interval_counts != nullptr};
    next += 2 * own;
    return taken;
}

double known_separation(const double *separations_arcsec, size_t i) {
    if (!(separations_arcsec[i] > 0 && std::isfinite(separations_arcsec[i])))
        fail(Status::argument, "{separations_arcsec[%zu]} = %g: must be above 0 and finite", i, separations_arcsec[i]);
    return separations_arcsec[i];
}

std::vector<sky::Measurement> measurements_of(const int64_t *intervals, const size_t *interval_counts,
                                              const double *separations_arcsec, const double *sigmas_arcsec,
                                              size_t count) {
    required_array(separations_arcsec, count, sizeof *separations_arcsec, "separations_arcsec");
    required_array(sigmas_arcsec, count, sizeof *sigmas_arcsec, "sigmas_arcsec");
    required_array(intervals, count, 2 * sizeof *intervals, "intervals");
    std::vector<sky::Measurement> measurements;
    for (size_t i = 0; i < count; i++) {
        const double separation = known_separation(separations_arcsec, i);
        if (!(sigmas_arcsec[i] > 0 && std::isfinite(sigmas_arcsec[i])))
            fail(Status::argument, "{sigmas_arcsec[%zu]} = %g: must be above 0 and finite", i, sigmas_arcsec[i]);
        measurements.push_back({take_exposure(intervals, interval_counts, i), separation, sigmas_arcsec[i]});
    }
    return measurements;
}

double known_scale_sigma(double scale_sigma) {
    if (!(scale_sigma >= 0 && scale_sigma < 1))
        fail(Status::argument, "{scale_sigma} = %g: must be in [0, 1)", scale_sigma);
    return scale_sigma;
}

} // namespace toliman::api
