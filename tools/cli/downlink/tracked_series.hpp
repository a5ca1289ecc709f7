// The samples of a state folder as a series, with its nuisance functions.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

#include "series/series.hpp"

namespace cli {

// A time in TAI, in units of unit_ns since time_offset_ns.
double time_of(int64_t tai_ns, const toliman_track_options &how);

// The columns of the periodogram: elements of the orbit whose errors are fitted. The coefficients are in px, the errors
// in units of the elements.
std::vector<NuisanceColumn> element_columns(const toliman::tracker &tracker);

// Those in the periodogram, in order of arrival; t in units of unit_ns since time_offset_ns.
Series tracked_series(const toliman::tracker &tracker);

} // namespace cli
