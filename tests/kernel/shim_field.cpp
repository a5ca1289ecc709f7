#include "kernels/blackbody.hpp"
#include "kernels/cis.hpp"
#include "kernels/field.hpp"

using namespace toliman::kernels;

extern "C" {

void shim_cis(double cycles, double *cosine, double *sine) {
    cis_cycles(cycles, *cosine, *sine);
}

double shim_reduce(double x) {
    return reduce_cycles(x);
}

double shim_blackbody(double wavelength_m, double temperature_k) {
    return blackbody_photons(wavelength_m, temperature_k);
}

void shim_pupil_field(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
                      const double *tilt_y, double *re, double *im) {
    pupil_field(amplitude, opd_m, n, wavenumber, tilt_x, tilt_y, {re, im});
}

void shim_tilt_derivative(double *re, double *im, size_t n, double step_x, double step_y) {
    tilt_derivative({re, im}, n, step_x, step_y, {re, im});
}

// Planes f, fx, fy, d2f in turn, real then imaginary, [8][count].
void shim_images(double *planes, size_t count, double weight, double axis_x, double axis_y, double *intensity,
                 double *derivative, double *curvature) {
    const auto field = [&](size_t i) { return Field{planes + 2 * i * count, planes + (2 * i + 1) * count}; };
    add_intensity(field(0), count, weight, intensity);
    add_derivative(field(0), field(1), count, weight, derivative);
    add_curvature(field(0), field(1), field(2), field(3), axis_x, axis_y, count, weight, curvature);
}
}
