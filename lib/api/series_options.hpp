// How to read the lines of a series.
#pragma once
#include <toliman/series.h>

#include "ingest/series.hpp"

namespace toliman::api {

// Status::argument, naming the option.
ingest::SeriesOptions series_options(const toliman_series_options &options);

} // namespace toliman::api
