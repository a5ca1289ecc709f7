// The samples of a state folder as a series of dates, for the search for planets.
#pragma once
#include <string>

#include "common/terminal.hpp"
#include "series/series.hpp"

namespace cli {

struct StateSeries {
    Series series;          // t in Modified Julian Days of TAI, y in px; with position angles if there is a system
    double plate_scale = 0; // arcsec per px of the reduction; 0 without
    std::string system;     // of the reduction, JSON; "" without
};

StateSeries dated_series(const std::string &folder, Progress &progress);

} // namespace cli
