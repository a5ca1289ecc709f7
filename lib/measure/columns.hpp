// Reads the functions of a series from a table.
#pragma once
#include <string>
#include <string_view>

#include "ingest/series.hpp"
#include "measure/series.hpp"

namespace toliman::measure {

// Adds the columns of a CSV table: the first line has the names t,NAME,...; a row for each sample of the series, with
// its time, in the same order. options: how the times of the series were read. Status::format, with name and line, for
// anything else.
void add_columns(std::string_view bytes, const std::string &name, const ingest::SeriesOptions &options, Series &series);

} // namespace toliman::measure
