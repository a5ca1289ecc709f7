// Parameters of the optics that each frame determines by itself.
#pragma once
#include <vector>

#include "optics/simulator.hpp"

namespace toliman::fit {

// Those of jitter_xx, jitter_yy, jitter_xy, focus and zernike_5 to zernike_11 that a frame of the scene determines well
// enough for a linear fit, with those that are always free and `others`. Without `others`.
std::vector<Parameter> self_parameters(const optics::Simulator &simulator, const std::vector<Parameter> &others,
                                       unsigned workers);

} // namespace toliman::fit
