// Method: a matrix Fourier transform F = sum E exp(-2 pi i (x u + y v) step), evaluated only at the pixels of interest,
// with the symmetric grids folded about both axes. For one axis, with e(x) = E(x) + E(-x) and o(x) = E(x) - E(-x),
//     sum_x E(x) exp(-2 pi i x u step) = sum_(x > 0) [e(x) cos(2 pi x u step) - i o(x) sin(2 pi x u step)]
// (a sample at x = 0 counts once), so that real matrices of half the size in each dimension suffice; the result at -u
// follows from the same two sums. The derivatives of the field with respect to tilts and modes are i phase times the
// field and pass through the same transform.
//
// Only +, - and * on phases in cycles (kernels/cis.hpp): the same bits on every instruction set.
// Reference: Soummer, Pueyo, Sivaramakrishnan and Vanderbei (2007), Opt. Express 15, 15935 (matrix Fourier transform).
#include "kernels/field.hpp"

#include "kernels/cis.hpp"

namespace toliman::kernels::TOLIMAN_ISA {
namespace {

// Twice the coordinate of folded sample i of an axis of n samples: an integer.
inline double twice_coordinate(size_t i, size_t n) noexcept {
    return static_cast<double>(2 * i + (n % 2 == 0 ? 1 : 0));
}

void operand(size_t samples, size_t pixels, long double step, double *cosine, double *sine) noexcept {
    const size_t width = half(pixels);
    const auto first = static_cast<double>(static_cast<float>(step / 4));
    const auto second = static_cast<double>(static_cast<float>(step / 4 - first));
    const auto third = static_cast<double>(step / 4 - first - second);
    const int odd = pixels % 2 == 0 ? 1 : 0;
    for (size_t x = 0; x < half(samples); x++) {
        const double x2 = twice_coordinate(x, samples);
        double *const c = cosine + x * width, *const s = sine + x * width;
        for (size_t u = 0; u < width; u++) {
            const double m = x2 * static_cast<double>(2 * static_cast<int>(u) + odd);
            const double cycles = reduce_cycles(m * first) + reduce_cycles(m * second) + m * third;
            cis_cycles(reduce_cycles(cycles), c[u], s[u]);
        }
    }
}

// Fields of one row: re[n], then im[n], of which samples first to end - 1 are computed; `stride` is the distance
// between fields.
struct Row {
    double *at;
    size_t stride, first, end;
};

void field_row(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
               double tilt_y, Row row) noexcept {
    double *const re = row.at, *const im = row.at + n;
    for (size_t x = row.first; x < row.end; x++) {
        const double cycles = reduce_cycles(opd_m[x] * wavenumber) + (tilt_x[x] + tilt_y);
        double cosine, sine;
        cis_cycles(reduce_cycles(cycles), cosine, sine);
        re[x] = amplitude[x] * cosine;
        im[x] = amplitude[x] * sine;
    }
}

void derived_row(const FieldTerm &term, size_t n, size_t y, size_t k, Row row) noexcept {
    const double centre = 0.5 * (static_cast<double>(n) - 1);
    const double along_y = term.slope_y * (static_cast<double>(y) - centre);
    const double *const re = row.at + term.parent * row.stride, *const im = re + n;
    double *const out_re = row.at + k * row.stride, *const out_im = out_re + n;
    if (term.mode != nullptr) {
        const double *const mode = term.mode + y * n;
        for (size_t x = row.first; x < row.end; x++) {
            const double slope = term.mode_scale * mode[x];
            out_re[x] = -slope * im[x];
            out_im[x] = slope * re[x];
        }
        return;
    }
    for (size_t x = row.first; x < row.end; x++) {
        const double slope = term.slope_x * (static_cast<double>(static_cast<int>(x)) - centre) + along_y;
        out_re[x] = -slope * im[x];
        out_im[x] = slope * re[x];
    }
}

// Folds `lit` samples of the rows `up` (y > 0) and `down` (y < 0) of one plane; part 0: real, 1: imaginary. The middle
// sample of an odd axis is its own mirror image and must count once.
void fold_rows(const double *up, const double *down, size_t n, size_t lit, bool middle, size_t part, double *even,
               double *odd) noexcept {
    const size_t h = half(n);
    double *const rows[4] = {even + part * h, even + (2 + part) * h, odd + part * h, odd + (2 + part) * h};
    const double *const up_right = up + (n - h), *const down_right = down + (n - h);
    const double once = middle ? 0.5 : 1;
    for (size_t x = 0; x < lit; x++) {
        const double up_left = up[h - 1 - x], down_left = down[h - 1 - x];
        const double up_even = up_right[x] + up_left, up_odd = up_right[x] - up_left;
        const double down_even = down_right[x] + down_left, down_odd = down_right[x] - down_left;
        rows[0][x] = once * (up_even + down_even);
        rows[1][x] = up_even - down_even;
        rows[2][x] = once * (up_odd + down_odd);
        rows[3][x] = up_odd - down_odd;
    }
    if (n % 2 != 0)
        for (int i = 0; i < 2; i++)
            rows[i][0] *= 0.5;
}

void fold(const double *amplitude, const double *opd_m, size_t n, const size_t *lit, double wavenumber,
          const double *tilt_x, const double *tilt_y, const FieldTerm *terms, size_t count, double *scratch,
          double *even, double *odd) noexcept {
    const size_t h = half(n), plane = 4 * h * h;
    for (size_t y = 0; y < h; y++) {
        const size_t first = h - lit[y], end = n - first;
        const Row sides[2] = {{scratch, 4 * n, first, end}, {scratch + 2 * n, 4 * n, first, end}};
        const size_t rows[2] = {n - h + y, h - 1 - y};
        for (size_t side = 0; side < 2; side++) {
            const size_t row = rows[side];
            field_row(amplitude + row * n, opd_m + row * n, n, wavenumber, tilt_x, tilt_y[row], sides[side]);
            for (size_t k = 1; k < count; k++) {
                const FieldTerm &term = terms[k - 1];
                const Row own = {sides[side].at + k * sides[side].stride, sides[side].stride, first, end};
                if (term.amplitude != nullptr)
                    field_row(term.amplitude + row * n, term.opd_m + row * n, n, wavenumber, tilt_x, tilt_y[row], own);
                else
                    derived_row(term, n, row, k, sides[side]);
            }
        }
        for (size_t k = 0; k < count; k++)
            for (size_t part = 0; part < 2; part++)
                fold_rows(sides[0].at + k * sides[0].stride + part * n, sides[1].at + k * sides[1].stride + part * n, n,
                          lit[y], rows[0] == rows[1], part, even + k * plane + 4 * y * h, odd + k * plane + 4 * y * h);
    }
}

// Combines the four transforms to one row of the focal field, re[cols] and im[cols]; sign: that of v.
void unfold_row(const double *ee, const double *eo, const double *oe, const double *oo, double sign, size_t cols,
                double *re, double *im) noexcept {
    const size_t w = half(cols);
    double *const right_re = re + (cols - w), *const right_im = im + (cols - w);
    for (size_t u = 0; u < w; u++) {
        const double same_re = ee[u] + sign * oe[w + u], same_im = ee[w + u] - sign * oe[u];
        const double flip_re = eo[w + u] - sign * oo[u], flip_im = eo[u] + sign * oo[w + u];
        re[w - 1 - u] = same_re - flip_re;
        im[w - 1 - u] = same_im + flip_im;
        right_re[u] = same_re + flip_re;
        right_im[u] = same_im - flip_im;
    }
}

void accumulate(const double *const *sums, size_t count, size_t rows, size_t cols, const FieldProduct *products,
                size_t product_count, double *scratch, double *const *images) noexcept {
    const size_t h = half(rows), w = half(cols);
    for (size_t row = 0; row < rows; row++) {
        const bool below = row < rows - h;
        const size_t v = below ? h - 1 - row : row - (rows - h);
        for (size_t k = 0; k < count; k++) {
            const size_t at = (k * h + v) * 2 * w;
            unfold_row(sums[0] + at, sums[1] + at, sums[2] + at, sums[3] + at, below ? -1 : 1, cols,
                       scratch + 2 * k * cols, scratch + (2 * k + 1) * cols);
        }
        for (size_t i = 0; i < product_count; i++) {
            const FieldProduct product = products[i];
            const double *const p = scratch + 2 * product.p * cols, *const q = scratch + 2 * product.q * cols;
            double *const image = images[product.image] + row * cols;
            for (size_t u = 0; u < cols; u++)
                image[u] += product.factor * (p[u] * q[u] + p[cols + u] * q[cols + u]);
        }
    }
}

} // namespace
} // namespace toliman::kernels::TOLIMAN_ISA

namespace toliman::kernels {
extern const FieldKernels TOLIMAN_ISA_TABLE(field) = {TOLIMAN_ISA::operand, TOLIMAN_ISA::fold, TOLIMAN_ISA::accumulate};
} // namespace toliman::kernels
