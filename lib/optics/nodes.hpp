// Chebyshev nodes in 1/lambda: a spectrum is replaced by fewer wavelengths that give the same polychromatic image.
#pragma once
#include "optics/light.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

// The light projected onto `count` nodes that span its wavelengths, for light that is not dispersed. The photons of a
// node may be negative.
Light project_on_nodes(const Light &light, size_t count);

// Photons in the brightest pixel of both stars' image, to a few per cent.
double rough_peak(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers);

// errors[M]: predicted largest error of both stars' image (photons) with M nodes, M = 1, 2, ...; errors[0] is not used.
// Evaluated on a coarse grid over the field of view; non-increasing in M.
std::vector<double> node_errors(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers);

} // namespace toliman::optics
