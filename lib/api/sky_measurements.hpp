// Measured separations as the functions of sky.h and sky_diagnosis.h take them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sky/refit.hpp"

namespace toliman::api {

std::vector<sky::Interval> intervals_of(const int64_t *intervals, size_t count);

// The exposure of measurement i, whose intervals begin at `next`; moves it to those of measurement i + 1.
// interval_counts: NULL for one interval of each.
sky::Exposure take_exposure(const int64_t *&next, const size_t *interval_counts, size_t i);

// Throw Error, naming the argument, for bad numbers.
double known_separation(const double *separations_arcsec, size_t i);
double known_scale_sigma(double scale_sigma);
std::vector<sky::Measurement> measurements_of(const int64_t *intervals, const size_t *interval_counts,
                                              const double *separations_arcsec, const double *sigmas_arcsec,
                                              size_t count);

} // namespace toliman::api
