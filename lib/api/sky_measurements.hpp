// Times and exposures as callers give them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sky/refit.hpp"

namespace toliman::api {

// interval_counts: NULL for one interval of each.
std::vector<sky::Exposure> exposures_of(const int64_t *intervals, const size_t *interval_counts, size_t count);

// Throws Error if all times are near 1970-01-01: they are not nanoseconds.
void check_exposures(const std::vector<sky::Exposure> &exposures);

// Throws Error, naming the argument, for a bad number.
double known_scale_sigma(double scale_sigma);

} // namespace toliman::api
