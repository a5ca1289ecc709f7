// Interface of the propagation engines: pupil fields of a star at one wavelength to focal fields on a grid of pixels.
#pragma once
#include <array>
#include <vector>

#include "base/buffer.hpp"
#include "base/constants.hpp"
#include "kernels/field.hpp"
#include "optics/pupil.hpp"

namespace toliman::optics {

// The pixels on which images are computed, symmetric about the axis. Pixel (x, y) is at the angle (u_x x, v_x x + v_y
// y) in units of the pitch.
struct Grid {
    size_t rows, cols;
    long double pitch_rad; // in double the edge of a frame would be off by 1e-14 px
    long double u_x = 1, v_x = 0, v_y = 1;
};

// An engine's work space, used by one thread at a time.
class Transform {
  public:
    virtual ~Transform() = default;

    // The pupil as sampled at a wavenumber (1/m); valid until the next call.
    virtual const Pupil &pupil(long double wavenumber) = 0;

    // Transforms the fields of a star at offset[x, y] px at the wavenumber given to pupil() last; terms as in
    // kernels/field.hpp, one fewer than the fields.
    virtual void transform(long double wavenumber, const long double *offset,
                           const std::vector<kernels::FieldTerm> &terms) = 0;

    // Adds products of the focal fields to images [rows][cols].
    virtual void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) = 0;
};

// Phase (cycles) per pupil sample and pixel, (D/N) p/lambda.
inline long double step_of(const Pupil &pupil, const Grid &grid, long double wavenumber) noexcept {
    return pupil.aperture_m * grid.pitch_rad * wavenumber / static_cast<long double>(pupil.samples);
}

// Photons in a pixel per |F|^2, of a star with these photons.
inline double intensity_factor(const Pupil &pupil, const Grid &grid, long double wavenumber, double photons) noexcept {
    const long double step = step_of(pupil, grid, wavenumber);
    const long double pixel = grid.u_x * grid.v_y; // area, in units of the squared pitch
    return static_cast<double>(photons * step * step * pixel / pupil.area);
}

// The angle, in units of the pitch, of a displacement [x, y] in pixels.
inline std::array<long double, 2> angle_of(const Grid &grid, long double x, long double y) noexcept {
    return {grid.u_x * x, grid.v_x * x + grid.v_y * y};
}

// The field of the derivative by a position along the unit vector (x, y), per px, from that of `parent`.
inline kernels::FieldTerm position_term(size_t parent, const Pupil &pupil, const Grid &grid, long double wavenumber,
                                        double x, double y) noexcept {
    const auto slope = static_cast<double>(2 * kLongPi * step_of(pupil, grid, wavenumber));
    const std::array<long double, 2> angle = angle_of(grid, x, y);
    return {parent, slope * static_cast<double>(angle[0]), slope * static_cast<double>(angle[1]), nullptr, 0};
}

// The field of the derivative by defocus, per nm rms, from that of `parent`.
inline kernels::FieldTerm focus_term(size_t parent, const Pupil &pupil, long double wavenumber) noexcept {
    return {parent, 0, 0, pupil.defocus.data(), static_cast<double>(2e-9L * kLongPi * wavenumber)};
}

// Linear phase (cycles) of each pupil column or row: `step` per sample, 0 at the centre, reduced to [-1/2, 1/2].
void tilt(long double step, Buffer<double> &cycles) noexcept;

} // namespace toliman::optics
