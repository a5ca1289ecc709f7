// What every engine does: fields of a star in one wavelength, from the pupil to the pixels of a grid.
#pragma once
#include <vector>

#include "base/buffer.hpp"
#include "kernels/field.hpp"
#include "optics/pupil.hpp"

namespace toliman::optics {

// The pixels on which images are computed, symmetric about the axis.
struct Grid {
    size_t rows, cols;
    long double pitch_rad; // double would put the edge of a frame 1e-14 px off
};

// Memory and operands of one thread.
class Transform {
  public:
    virtual ~Transform() = default;

    // The pupil as it is sampled at a wavenumber (1/m); lives until the next call.
    virtual const Pupil &pupil(long double wavenumber) = 0;

    // Transforms the fields of a star at offset[x, y] px in the wavenumber of the last pupil(); terms as in
    // kernels/field.hpp, one less than the fields.
    virtual void transform(long double wavenumber, const long double *offset,
                           const std::vector<kernels::FieldTerm> &terms) = 0;

    // Adds products of the focal fields to images [rows][cols].
    virtual void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) = 0;
};

// Phase in cycles of one pupil sample times one pixel, (D/N) p/lambda.
inline long double step_of(const Pupil &pupil, const Grid &grid, long double wavenumber) noexcept {
    return pupil.aperture_m * grid.pitch_rad * wavenumber / static_cast<long double>(pupil.samples);
}

// Phase in cycles of each pupil column (or row) when each adds `step`, 0 at the centre, reduced to half a cycle.
void tilt(long double step, Buffer<double> &cycles) noexcept;

} // namespace toliman::optics
