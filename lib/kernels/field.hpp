// Complex fields as two real planes: the pupil's field, its derivatives by tilt, and intensities of focal fields.
#pragma once
#include <cstddef>

namespace toliman::kernels {

struct Field {
    double *re, *im;
};

// Given     amplitude [n][n]; opd_m [n][n]; wavenumber 1/lambda (1/m); tilt_x, tilt_y [n], cycles in [-1/2, 1/2], the
//           tilt's phase of each column and row
// Returned  field [n][n] = amplitude exp(2 pi i (opd/lambda + tilt_x + tilt_y))
// Notes     phases are reduced to half a cycle before any sine, so that large tilts cost no accuracy.
void pupil_field(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
                 const double *tilt_y, Field field) noexcept;

// Given     field [n][n]; step_x, step_y: change of phase (rad) from a pupil sample to the next per pixel of tilt
// Returned  derivative [n][n] = i (step_x x + step_y y) field, x and y in samples from the centre; may be field itself
void tilt_derivative(Field field, size_t n, double step_x, double step_y, Field derivative) noexcept;

// Given     f [count], weight
// Returned  image [count] increased by weight |f|^2
void add_intensity(Field f, size_t count, double weight, double *image) noexcept;

// Given     f, df [count]: a field and its derivative
// Returned  image [count] increased by weight d|f|^2 = weight 2 Re(conj(f) df)
void add_derivative(Field f, Field df, size_t count, double weight, double *image) noexcept;

// Given     f, fx, fy, d2f [count]: a field, its derivatives along x and y and the second along the unit vector
//           (axis_x, axis_y)
// Returned  image [count] increased by weight d2|f|^2 = weight 2 (|df|^2 + Re(conj(f) d2f)), df = axis_x fx + axis_y fy
void add_curvature(Field f, Field fx, Field fy, Field d2f, double axis_x, double axis_y, size_t count, double weight,
                   double *image) noexcept;

} // namespace toliman::kernels
