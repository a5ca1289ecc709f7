#include <vector>

#include "kernels/fold.hpp"

using namespace toliman::kernels;

extern "C" {

void shim_operand(size_t samples, size_t pixels, long double step, double *cosine, double *sine) {
    fourier_operand(samples, pixels, step, cosine, sine);
}

// The whole transform with plain loops for the products.
void shim_transform(double *re, double *im, size_t n, size_t rows, size_t cols, long double step, double *out_re,
                    double *out_im) {
    const size_t h = half(n), v = half(rows), u = half(cols);
    std::vector<double> cosine_x(h * u), sine_x(h * u), cosine_y(h * v), sine_y(h * v);
    std::vector<double> folded[2] = {std::vector<double>(4 * h * h), std::vector<double>(4 * h * h)}, sums[4];
    fourier_operand(n, cols, step, cosine_x.data(), sine_x.data());
    fourier_operand(n, rows, step, cosine_y.data(), sine_y.data());
    fold({re, im}, n, folded[0].data(), folded[1].data());
    for (size_t part = 0; part < 4; part++) { // ee, eo, oe, oo: y first
        const size_t odd_y = part / 2, odd_x = part % 2;
        const std::vector<double> &along_x = odd_x ? sine_x : cosine_x, &along_y = odd_y ? sine_y : cosine_y;
        sums[part].assign(2 * v * u, 0);
        for (size_t i = 0; i < v; i++)
            for (size_t plane = 0; plane < 2; plane++)
                for (size_t j = 0; j < u; j++)
                    for (size_t y = 0; y < h; y++)
                        for (size_t x = 0; x < h; x++)
                            sums[part][(2 * i + plane) * u + j] += folded[odd_x][(4 * y + 2 * odd_y + plane) * h + x] *
                                                                   along_x[x * u + j] * along_y[y * v + i];
    }
    unfold(sums[0].data(), sums[1].data(), sums[2].data(), sums[3].data(), rows, cols, {out_re, out_im});
}
}
