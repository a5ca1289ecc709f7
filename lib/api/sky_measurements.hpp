// Measured separations as the functions of sky.h and sky_diagnosis.h take them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sky/refit.hpp"

namespace toliman::api {

std::vector<sky::Interval> intervals_of(const int64_t *intervals, size_t count);

// interval_counts: NULL for one interval of each.
std::vector<sky::Exposure> exposures_of(const int64_t *intervals, const size_t *interval_counts, size_t count);

// Throw Error if all times are near 1970-01-01: they are not nanoseconds. name: of the argument.
void check_times(const char *name, const int64_t *times, size_t count);
void check_exposures(const std::vector<sky::Exposure> &exposures);

// Throws Error if the median of measured over predicted separations is far from 1: another unit. NaN does not count.
void check_unit(std::vector<double> ratios);

// Throw Error, naming the argument, for bad numbers.
double known_separation(const double *separations_arcsec, size_t i);
double known_scale_sigma(double scale_sigma);
std::vector<sky::Measurement> measurements_of(const int64_t *intervals, const size_t *interval_counts,
                                              const double *separations_arcsec, const double *sigmas_arcsec,
                                              size_t count);

} // namespace toliman::api
