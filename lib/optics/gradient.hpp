// The gradient of a weighted sum of pixels by the OPD of every pupil cell, at the cost of a few images.
#pragma once
#include "optics/light.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

// Adds the derivative of sum over pixels of weights [rows][cols] times the image of a star by the OPD (m) of each cell
// to gradient [N][N]. Image, light and grid as in propagate(), without displacement. The bits do not depend on workers.
void add_opd_gradient(const Pupil &pupil, const Light &light, const Grid &grid, size_t star, const double *weights,
                      unsigned workers, double *gradient);

// The same for the sum over `spectra` of weights[k] times the image that star 0 would have with spectra[k]
// [wavelength], in photons at the wavelengths of `light`: they have their transforms in common.
void add_opd_gradient(const Pupil &pupil, const Light &light, const Grid &grid,
                      const std::vector<std::vector<double>> &spectra, const std::vector<const double *> &weights,
                      unsigned workers, double *gradient);

// Weights [rows][cols] of the pixels of a star's image and of its derivatives along and across the axis of the light,
// per px, and by focus, per nm.
struct ImageWeights {
    const double *image, *along, *across, *focus;
};

// Adds the derivative of the weighted sum of these images by the covered fraction of each mixed cell to gradient
// [mixed]. The bits do not depend on workers.
void add_coverage_gradient(const Pupil &pupil, const Light &light, const Grid &grid, size_t star,
                           const ImageWeights &weights, unsigned workers, double *gradient);

} // namespace toliman::optics
