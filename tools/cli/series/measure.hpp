// Series of the program and those of the library.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/measure_values.hpp"
#include "series/series.hpp"

namespace cli {

// For the library, with its functions. kind: TOLIMAN_MEASURE_..., unit: arcsec (velocities: m/s) per unit of y, 0 =
// unknown. intervals: [samples][2], start and end of the exposures, TAI ns; empty: not known.
toliman::measurements measure_of(const Series &series, int32_t kind, double unit,
                                 const std::vector<int64_t> &intervals = {});

// The values of the functions that are fitted with the mean, [function][sample].
std::vector<std::vector<double>> functions_of(const Series &series);

// For the program; name: of its source in messages.
Series series_of(const toliman_measure *measure, const std::string &name);

} // namespace cli
