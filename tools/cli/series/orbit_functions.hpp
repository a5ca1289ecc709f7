// Reduces a series to the orbit of its binary; fits the errors of that orbit with the mean.
#pragma once
#include <string>

#include "series/nuisance_options.hpp"
#include "series/reduction.hpp"

namespace cli {

// Replaces a series of measured separations by the reduced ones. with_functions: unless the options name functions, it
// gets those that are fitted by default: the partial derivatives of the separation by the orbital elements, with the
// priors of the system, or, with a warning, a trend if there are no priors or no sigmas.
ReductionNote reduce_to_orbit(const std::string &system, const ReductionOptions &reduction,
                              const NuisanceOptions &nuisance, bool with_functions, Series &series, Progress &progress);

} // namespace cli
