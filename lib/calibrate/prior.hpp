// Parameters to fit, and their priors, from text.
#pragma once
#include <string>

#include "calibrate/problem.hpp"

namespace toliman::calibrate {

// Standard deviation of the default prior.
double default_sigma(Parameter parameter) noexcept;

// The parameters of `text`: NAME, NAME=SIGMA or NAME-LAST=SIGMA separated by spaces, as in
// toliman_calibration_options.free. Empty: the default ones that the scene has. Status::argument or unsupported.
std::vector<Free> free_of(const std::string &text, const Scene &scene, const optics::Plan &plan);

} // namespace toliman::calibrate
