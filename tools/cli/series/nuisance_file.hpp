// Reads the columns of --nuisance-file.
#pragma once
#include "series/series.hpp"

namespace cli {

// CSV: the first line has the names t,NAME,...; a row for each sample of the series, with its time, in the same order.
// samples: how the times of the series were read. Throws Failure, with file and line, for anything else.
std::vector<NuisanceColumn> read_columns(const std::string &path, const Series &series, const SampleOptions &samples);

} // namespace cli
