// The errors of the reference orbit as columns of a series of reduced separations.
#pragma once
#include <optional>

#include "series/reduction.hpp"

namespace cli {

constexpr int32_t kOrbitTrend = 4; // order of the trend in place of the columns: leaves 0.06 uas of alpha Centauri

// The partial derivatives of the separation by the orbital elements, with the priors of the system. Empty if they have
// none; `why` then states the reason. scale_sigma: standard deviation of the relative error of the plate scale.
std::optional<Nuisance> orbit_functions(const Measurements &measured, const toliman_sky *sky, double plate_scale,
                                        double scale_sigma, std::string &why);

} // namespace cli
