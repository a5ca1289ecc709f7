#include "kernels/field.hpp"

#include "kernels/cis.hpp"

namespace toliman::kernels {

void pupil_field(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
                 const double *tilt_y, Field field) noexcept {
    for (size_t y = 0; y < n; y++) {
        for (size_t x = 0; x < n; x++) {
            const size_t i = y * n + x;
            const double cycles = reduce_cycles(opd_m[i] * wavenumber) + (tilt_x[x] + tilt_y[y]);
            double cosine, sine;
            cis_cycles(reduce_cycles(cycles), cosine, sine);
            field.re[i] = amplitude[i] * cosine;
            field.im[i] = amplitude[i] * sine;
        }
    }
}

void tilt_derivative(Field field, size_t n, double step_x, double step_y, Field derivative) noexcept {
    const double centre = 0.5 * (static_cast<double>(n) - 1);
    for (size_t y = 0; y < n; y++) {
        const double row = step_y * (static_cast<double>(y) - centre);
        for (size_t x = 0; x < n; x++) {
            const size_t i = y * n + x;
            const double slope = step_x * (static_cast<double>(x) - centre) + row, re = field.re[i];
            derivative.re[i] = -slope * field.im[i];
            derivative.im[i] = slope * re;
        }
    }
}

void add_intensity(Field f, size_t count, double weight, double *image) noexcept {
    for (size_t i = 0; i < count; i++)
        image[i] += weight * (f.re[i] * f.re[i] + f.im[i] * f.im[i]);
}

void add_derivative(Field f, Field df, size_t count, double weight, double *image) noexcept {
    for (size_t i = 0; i < count; i++)
        image[i] += 2 * weight * (f.re[i] * df.re[i] + f.im[i] * df.im[i]);
}

void add_curvature(Field f, Field fx, Field fy, Field d2f, double axis_x, double axis_y, size_t count, double weight,
                   double *image) noexcept {
    for (size_t i = 0; i < count; i++) {
        const double re = axis_x * fx.re[i] + axis_y * fy.re[i], im = axis_x * fx.im[i] + axis_y * fy.im[i];
        image[i] += 2 * weight * (re * re + im * im + f.re[i] * d2f.re[i] + f.im[i] * d2f.im[i]);
    }
}

} // namespace toliman::kernels
