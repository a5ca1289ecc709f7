// C interface of the field kernels, each instruction set by number.
#include <algorithm>
#include <vector>

#include "isa_tables.hpp"
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

void shim_operand(int isa, size_t samples, size_t pixels, long double step, double *cosine, double *sine) {
    KERNELS(field, isa).operand(samples, pixels, step, cosine, sine);
}

// The whole transform, with plain loops for the matrix products. images [3][rows][cols]: the squared modulus of field
// 0, the product of fields 0 and 1 (derivative of 0 by slopes), the product of fields 1 and 2 (derivative of 1 by a
// mode). Each is added to the existing values.
void shim_transform(int isa, const double *amplitude, const double *opd_m, size_t n, double wavenumber,
                    const double *tilt_x, const double *tilt_y, double slope_x, double slope_y, const double *mode,
                    double mode_scale, size_t rows, size_t cols, long double step, double weight, double *images) {
    const FieldKernels &kernels = KERNELS(field, isa);
    const size_t h = half(n), v = half(rows), u = half(cols), count = 3;
    const FieldTerm terms[] = {{0, slope_x, slope_y, nullptr, 0}, {1, 0, 0, mode, mode_scale}};
    std::vector<double> cosine_x(h * u), sine_x(h * u), cosine_y(h * v), sine_y(h * v);
    std::vector<double> folded[2] = {std::vector<double>(count * 4 * h * h), std::vector<double>(count * 4 * h * h)};
    std::vector<double> scratch(count * (4 * n + 2 * cols)), sums[4];
    kernels.operand(n, cols, step, cosine_x.data(), sine_x.data());
    kernels.operand(n, rows, step, cosine_y.data(), sine_y.data());
    std::vector<size_t> lit(h);
    for (size_t y = 0; y < n; y++)
        for (size_t x = 0; x < n; x++)
            if (amplitude[y * n + x] > 0) {
                size_t &most = lit[y < h ? h - 1 - y : y + h - n];
                most = std::max(most, x < h ? h - x : x + h - n + 1);
            }
    kernels.fold(amplitude, opd_m, n, lit.data(), wavenumber, tilt_x, tilt_y, terms, count, scratch.data(),
                 folded[0].data(), folded[1].data());
    for (size_t part = 0; part < 4; part++) { // parity of y, then of x
        const size_t odd_y = part / 2, odd_x = part % 2;
        const std::vector<double> &along_x = odd_x ? sine_x : cosine_x, &along_y = odd_y ? sine_y : cosine_y;
        sums[part].assign(count * 2 * v * u, 0);
        for (size_t field = 0; field < count; field++)
            for (size_t i = 0; i < v; i++)
                for (size_t plane = 0; plane < 2; plane++)
                    for (size_t j = 0; j < u; j++)
                        for (size_t y = 0; y < h; y++)
                            for (size_t x = 0; x < h; x++)
                                sums[part][((field * v + i) * 2 + plane) * u + j] +=
                                    folded[odd_x][((field * h + y) * 4 + 2 * odd_y + plane) * h + x] *
                                    along_x[x * u + j] * along_y[y * v + i];
    }
    const double *const all[] = {sums[0].data(), sums[1].data(), sums[2].data(), sums[3].data()};
    const FieldProduct products[] = {{0, 0, 0, weight}, {1, 0, 1, 2 * weight}, {2, 1, 2, weight}};
    double *const images_of[] = {images, images + rows * cols, images + 2 * rows * cols};
    kernels.accumulate(all, count, rows, cols, products, 3, scratch.data(), images_of);
}
}
