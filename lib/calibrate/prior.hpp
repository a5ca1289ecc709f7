// Parameters to fit, and their priors, from text.
#pragma once
#include <string>

#include "calibrate/problem.hpp"

namespace toliman::calibrate {

// Standard deviation of the default prior.
double default_sigma(Parameter parameter, double peak_e) noexcept; // peak_e: charge of the brightest pixel

// The parameters that are fitted by default.
extern const char *const kDefaultParameters;

// The parameters of `text`: NAME, NAME=SIGMA or NAME-LAST=SIGMA separated by spaces, as in
// toliman_calibration_options.free. Empty, or each with + before it: the default ones that the scene has, and
// these. Status::argument or unsupported.
// left_out: gets the default ones that the scene does not have.
std::vector<Free> free_of(const std::string &text, const Scene &scene, const optics::Plan &plan, double peak_e,
                          std::vector<LeftOut> *left_out = nullptr);

// The text with the parameters of the detector's readout, if it adds to the default ones; those that are linear, for
// sums of frames.
std::string with_readout(const std::string &text, bool sums);

} // namespace toliman::calibrate
