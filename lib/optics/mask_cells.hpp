// A spiral mask on the cells of the pupil: the fraction of each cell where the mask steps.
#pragma once
#include "optics/pupil.hpp"

namespace toliman::optics {

// Fraction [samples][samples] of each cell where the sum of the mask's terms is positive, with the mask rotated and
// shifted as the scene says. Edges::cell: 0 or 1, by the sign at the cell's centre. Edges::area: the area, continuous
// in rotation and shift; of closed cells (amplitude [samples][samples] is 0) the sign. mask must be a spiral.
Buffer<double> covered_fractions(const Mask &mask, double aperture_m, size_t samples, const Buffer<double> &amplitude);

// The same of these cells, which are open; Edges::area.
std::vector<double> covered_fractions(const Mask &mask, double aperture_m, size_t samples,
                                      const std::vector<MixedCell> &cells);

// The sum of the mask's terms, not rotated or shifted, at the centres of points x points cells of the aperture.
Buffer<double> sum_of_terms(const Mask &mask, size_t points);

} // namespace toliman::optics
