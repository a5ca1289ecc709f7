#include "kernels/fold.hpp"

#include <cmath>

#include "kernels/cis.hpp"

namespace toliman::kernels {

namespace {

// Coordinate of folded sample i of an axis of n.
double coordinate(size_t i, size_t n) noexcept {
    return static_cast<double>(i) + (n % 2 == 0 ? 0.5 : 0.0);
}

// Folds one plane of the field; part 0 is the real one, 1 the imaginary.
void fold_plane(const double *plane, size_t n, size_t part, double *even, double *odd) noexcept {
    const size_t h = half(n);
    for (size_t y = 0; y < h; y++) {
        const double *up = plane + (n - h + y) * n, *down = plane + (h - 1 - y) * n;
        double *rows[4] = {even + (4 * y + part) * h, even + (4 * y + 2 + part) * h, odd + (4 * y + part) * h,
                           odd + (4 * y + 2 + part) * h};
        // The middle sample of an odd axis is its own mirror image and counts once.
        const double mirrored_y = up == down ? 0 : 1;
        for (size_t x = 0; x < h; x++) {
            const size_t right = n - h + x, left = h - 1 - x;
            const double mirrored_x = right == left ? 0 : 1;
            const double up_even = up[right] + mirrored_x * up[left], up_odd = up[right] - up[left];
            const double down_even = mirrored_y * (down[right] + mirrored_x * down[left]);
            const double down_odd = mirrored_y * (down[right] - down[left]);
            rows[0][x] = up_even + down_even;
            rows[1][x] = mirrored_y * (up_even - down_even);
            rows[2][x] = up_odd + down_odd;
            rows[3][x] = mirrored_y * (up_odd - down_odd);
        }
    }
}

} // namespace

void fourier_operand(size_t samples, size_t pixels, long double step, double *cosine, double *sine) noexcept {
    const size_t width = half(pixels);
    for (size_t x = 0; x < half(samples); x++) {
        for (size_t u = 0; u < width; u++) {
            const long double cycles = step * (coordinate(x, samples) * coordinate(u, pixels));
            cis_cycles(static_cast<double>(cycles - std::rint(cycles)), cosine[x * width + u], sine[x * width + u]);
        }
    }
}

void fold(Field field, size_t n, double *even, double *odd) noexcept {
    fold_plane(field.re, n, 0, even, odd);
    fold_plane(field.im, n, 1, even, odd);
}

void unfold(const double *ee, const double *eo, const double *oe, const double *oo, size_t rows, size_t cols,
            Field field) noexcept {
    const size_t h = half(rows), w = half(cols);
    for (size_t r = 0; r < rows; r++) {
        const bool below = r < rows - h;
        const size_t v = below ? h - 1 - r : r - (rows - h);
        const double sign_v = below ? -1 : 1;
        const double *ee_re = ee + 2 * v * w, *eo_re = eo + 2 * v * w, *oe_re = oe + 2 * v * w, *oo_re = oo + 2 * v * w;
        const double *ee_im = ee_re + w, *eo_im = eo_re + w, *oe_im = oe_re + w, *oo_im = oo_re + w;
        double *right_re = field.re + r * cols + (cols - w), *right_im = field.im + r * cols + (cols - w);
        double *left_re = field.re + r * cols + (w - 1), *left_im = field.im + r * cols + (w - 1);
        for (size_t u = 0; u < w; u++) {
            const double same_re = ee_re[u] + sign_v * oe_im[u], same_im = ee_im[u] - sign_v * oe_re[u];
            const double flip_re = eo_im[u] - sign_v * oo_re[u], flip_im = eo_re[u] + sign_v * oo_im[u];
            *(left_re - u) = same_re - flip_re;
            *(left_im - u) = same_im + flip_im;
            right_re[u] = same_re + flip_re;
            right_im[u] = same_im - flip_im;
        }
    }
}

} // namespace toliman::kernels
