// Measured separations: their reduction to the orbit, and as the refit of the orbit takes them.
#pragma once
#include <string>

#include "measure/series.hpp"

namespace toliman::measure {

// Parallax and masses of the system, and whether it was refitted to measurements of these times.
void set_stars(const sky::System &system, const std::vector<int64_t> &tai_ns, Series &series);

struct Reduction {
    Series series;
    std::string warning; // "" for none
};

// Reduced separations with the position angles of their date; samples for which the observer file has no state count in
// left_out. with_functions: a series without functions gets the errors of the elements, with their priors, or a trend
// if there are no priors or no sigmas. scale_sigma: standard deviation of the relative error of the plate scale.
// Status::argument, naming the sample, for another kind of series, an unknown unit, exposures that are not known, and
// separations in another unit; Status::range if no sample is left.
Reduction reduce(const Series &measured, const sky::Predictor &predictor, double scale_sigma, bool with_functions);

// In arcsec. Status::argument, naming the sample, as reduce(), and without sigmas.
std::vector<sky::Measurement> measurements_of(const Series &measured);

// Those for which the observer file has states.
std::vector<sky::Measurement> covered(const sky::Predictor &predictor, std::vector<sky::Measurement> measurements);

} // namespace toliman::measure
