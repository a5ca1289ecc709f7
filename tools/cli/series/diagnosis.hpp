// What is wrong with measured separations, if they do not agree with their predictions.
#pragma once
#include <optional>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "common/terminal.hpp"

namespace cli {

// If the chi-square about the orbit is poor and a wrong time scale, wrong axes or a wrong plate scale explain it, warns
// of that and returns it as JSON: cause, text, value, sigma, chi_square before and after, significance. Otherwise, and
// without sigmas, nothing.
std::optional<Json> diagnosis_of(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                                 Progress &progress);

} // namespace cli
