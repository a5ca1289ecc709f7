// Samples that do not belong to a series, by their times.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/json.hpp"
#include "series/series.hpp"

namespace cli {

// The times of the first ten: dates, where times are dates.
std::string listed_outliers(const std::vector<int64_t> &indices, const Series &series);

// [{"index": 7, "t": 61041.5}, ...]
std::vector<Json> json_of_outliers(const std::vector<int64_t> &indices, const Series &series);

} // namespace cli
