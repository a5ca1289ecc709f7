// Fewer wavelengths for the same image. The image of one wavelength, less a factor 1/lambda^2, is band-limited in
// 1/lambda, so that it can be interpolated between Chebyshev nodes there, and a spectrum of any shape can be projected
// onto them.
#pragma once
#include "optics/light.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

// The same light on `count` nodes that span its wavelengths: photons of a node may be negative.
// Reference: Berrut and Trefethen 2004 (barycentric interpolation).
Light project_on_nodes(const Light &light, size_t count);

// Photons of both stars' brightest pixel, to a few per cent.
double rough_peak(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers);

// Expected largest error of both stars' image, in photons, for each number of nodes from 0 on. It is found on a few
// pixels all over the grid, where the Chebyshev coefficients of the intensity and the moments of the spectrum are
// computed: the error is what the moments beyond the nodes would have added.
std::vector<double> node_errors(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers);

} // namespace toliman::optics
