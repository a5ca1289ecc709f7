// Second derivatives of the expected frame by parameters of the forward model.
#pragma once
#include <optional>

#include "optics/simulator.hpp"
#include "scene/parameter.hpp"

namespace toliman::information {

// Half the second derivative of the frame by a parameter, electrons per unit^2 in each pixel; empty if the frame
// depends linearly on it, or if it is a multiple of the first derivative. None where it is not computed: jitter, whose
// variances may not become negative; motions of the mask, whose covered areas are not smooth enough; the padded FFT.
std::optional<Buffer<double>> half_curvature(const optics::Simulator &simulator, Parameter parameter);

} // namespace toliman::information
