// Interpolation of a dense image from every other sample, where these determine it.
#pragma once
#include <vector>

#include "base/buffer.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

// Weights of the samples at distances 1/2, 3/2, ... on both sides of a sample between two.
using HalfBand = std::vector<double>;

// cutoff: highest frequency of the image in cycles per dense sample. The error is about `accuracy` of the peak. Empty
// if every other sample is too few.
HalfBand make_half_band(double cutoff, double accuracy);

// Every other sample of a grid with an odd number of rows and columns, and those beyond it that the weights reach.
Grid sparse_grid(const Grid &dense, const HalfBand &weights) noexcept;

// The image on `dense` from that on its sparse_grid().
Buffer<double> interpolated(const Buffer<double> &sparse, const Grid &dense, const HalfBand &weights);

// The adjoint of interpolated().
Buffer<double> spread(const Buffer<double> &image, const Grid &dense, const HalfBand &weights);

} // namespace toliman::optics
