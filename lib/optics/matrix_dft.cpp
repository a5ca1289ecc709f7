// Method: matrix Fourier transform (Soummer et al. 2007): with E the N x N pupil field the focal field is
//     F = M_v E M_u^T,   M_u[j][i] = exp(-2 pi i u_j x_i / lambda),
// two matrix products, for pixels u_j at any pitch and any number of them.
// Why not a padded FFT: its pupil samples N_E = N_out p D/lambda must be an integer, so that each wavelength's plate
// scale is off by up to 0.26 % (padded_fft.cpp). Here positions are exact, nothing is interpolated, and only the
// detector's pixels are computed.
// Folding: both grids are symmetric about 0, so that the parts of E even and odd in x and y meet only cosines or sines.
// The complex products become real ones with a quarter of the flops (measured 2.5 times faster, equal to 1.1e-15).
// Pixels whose rows are tilted, v = v_x x + v_y y, multiply the field between the two products by exp(-2 pi i y_pupil
// v_x x / lambda); both grids remain regular.
// Adjoint: sums over the pixels of a field H, with exp(+2 pi i (x u + y v)), are the same products in reverse order.
// With H folded by parity in v and u, and i times the parts that are odd in v, -i times those odd in u, both passes and
// the tilt of the rows are those of the transform.
// Error: max error / peak of an image 3e-15 to 7e-15 against an 80-bit sum.
// Reference: Soummer, Pueyo, Sivaramakrishnan and Vanderbei 2007, Optics Express 15, 15935.
#include "optics/matrix_dft.hpp"

#include <algorithm>

#include "backend/blas.hpp"
#include "base/constants.hpp"
#include "kernels/cis.hpp"

namespace toliman::optics {

namespace {

using kernels::field_kernels;
using kernels::half;

// Products are cut into tiles of m n k <= 2^18, which OpenBLAS always runs on the calling thread. A product that it
// splits over threads is rounded differently, and the image would depend on the number of threads. Tiles of 64 x 32 at
// k = 128 cost nothing (measured 5 % faster than whole products).
constexpr size_t kLargestTile = size_t{1} << 18, kTileColumns = 32;

size_t tile_rows(size_t k) noexcept {
    return std::max<size_t>(1, kLargestTile / (kTileColumns * k));
}

// Number of samples of each folded row up to the last that is open in any of the four quadrants.
std::vector<size_t> lit_samples_of(const Pupil &pupil) {
    const size_t n = pupil.samples, h = half(n);
    std::vector<size_t> lit(h);
    for (size_t y = 0; y < h; y++)
        for (const size_t row : {n - h + y, h - 1 - y})
            for (size_t col = 0; col < n; col++)
                if (pupil.amplitude[row * n + col] != 0)
                    lit[y] = std::max(lit[y], col < h ? h - col : col + 1 - (n - h));
    return lit;
}

} // namespace

MatrixDft::MatrixDft(const Pupil &pupil, const Grid &grid, size_t fields)
    : pupil_(pupil), grid_(grid), fields_(fields), lit_samples_(lit_samples_of(pupil)), tilt_x_(pupil.samples),
      tilt_y_(pupil.samples) {
    const size_t h = half(pupil.samples), v = half(grid.rows), u = half(grid.cols);
    for (Buffer<double> *operand : {&cosine_x_, &sine_x_})
        operand->resize(h * u);
    for (Buffer<double> *operand : {&cosine_y_, &sine_y_})
        operand->resize(h * v);
    for (Buffer<double> *folded : {&even_, &odd_})
        folded->resize(fields * 4 * h * h);
    for (UnsetBuffer<double> *middle : {&even_middle_, &odd_middle_})
        middle->resize(fields * 4 * h * u);
    for (UnsetBuffer<double> *sums : {&ee_, &eo_, &oe_, &oo_})
        sums->resize(fields * 2 * v * u);
    if (grid.v_x != 0)
        for (Buffer<double> *operand : {&shear_cosine_, &shear_sine_})
            operand->resize(h * u);
    scratch_.resize(fields * std::max(4 * pupil.samples, 2 * grid.cols));
    if (!pupil.mixed.empty()) {
        amplitude_ = pupil.amplitude;
        opd_m_ = pupil.opd_m;
    }
}

// middle = folded times operand, row by row of folded [field][y][4][x]; samples beyond the last lit one are skipped.
void MatrixDft::along_x(const Buffer<double> &folded, const Buffer<double> &operand,
                        UnsetBuffer<double> &middle) noexcept {
    const size_t h = half(pupil_.samples), u = half(grid_.cols), rows_at_once = std::max<size_t>(1, tile_rows(h) / 4);
    for (size_t field = 0; field < fields_; field++)
        for (size_t y = 0; y < h; y += rows_at_once) {
            const size_t count = std::min(rows_at_once, h - y), first = (field * h + y) * 4;
            const size_t lit =
                std::max<size_t>(1, *std::max_element(lit_samples_.data() + y, lit_samples_.data() + y + count));
            for (size_t j = 0; j < u; j += kTileColumns)
                blas::dgemm(false, 4 * count, std::min(kTileColumns, u - j), lit, folded.data() + first * h, h,
                            operand.data() + j, u, middle.data() + first * u + j, u);
        }
}

// sums [field][v][2][u] = operand^T middle, of the part of middle that is even (0) or odd (1) in y.
void MatrixDft::along_y(const UnsetBuffer<double> &middle, size_t part, const Buffer<double> &operand,
                        UnsetBuffer<double> &sums) noexcept {
    const size_t h = half(pupil_.samples), v = half(grid_.rows), width = 2 * half(grid_.cols), tile = tile_rows(h);
    for (size_t field = 0; field < fields_; field++) {
        const double *const from = middle.data() + field * h * 2 * width + part * width;
        double *const to = sums.data() + field * v * width;
        for (size_t i = 0; i < v; i += tile)
            for (size_t j = 0; j < width; j += kTileColumns)
                blas::dgemm(true, std::min(tile, v - i), std::min(kTileColumns, width - j), h, operand.data() + i, v,
                            from + j, 2 * width, to + i * width + j, width);
    }
}

// Multiplies the middle by exp(-2 pi i y j step), y the pupil row and j the pixel's column. With P the middle that is
// even in j, -i Q the odd one, and C - i S the factor, whose sine is odd in y and in j, each pair of opposite parities
// in y rotates: P' = P C - Q S, Q' = Q C + P S.
void MatrixDft::shear(long double step) noexcept {
    const size_t h = half(pupil_.samples), u = half(grid_.cols);
    field_kernels().operand(pupil_.samples, grid_.cols, step, shear_cosine_.data(), shear_sine_.data());
    for (size_t row = 0; row < fields_ * h; row++) {
        const double *const cosine = shear_cosine_.data() + row % h * u, *const sine = shear_sine_.data() + row % h * u;
        for (size_t part = 0; part < 4; part++) {
            double *const p = even_middle_.data() + (4 * row + part) * u;
            double *const q = odd_middle_.data() + (4 * row + (part + 2) % 4) * u;
            for (size_t j = 0; j < u; j++) {
                const double before = p[j];
                p[j] = before * cosine[j] - q[j] * sine[j];
                q[j] = q[j] * cosine[j] + before * sine[j];
            }
        }
    }
}

void MatrixDft::transform(long double wavenumber, const long double *offset,
                          const std::vector<kernels::FieldTerm> &terms) noexcept {
    const long double step = step_of(pupil_, grid_, wavenumber);
    const size_t n = pupil_.samples;
    const auto angle = angle_of(grid_, offset[0], offset[1]);
    tilt(angle[0] * step, tilt_x_);
    tilt(angle[1] * step, tilt_y_);
    field_kernels().operand(n, grid_.cols, step * grid_.u_x, cosine_x_.data(), sine_x_.data());
    const bool square = grid_.rows == grid_.cols && grid_.u_x == grid_.v_y;
    if (!square)
        field_kernels().operand(n, grid_.rows, step * grid_.v_y, cosine_y_.data(), sine_y_.data());
    const bool mixed = !pupil_.mixed.empty();
    if (mixed)
        resolve_mixed(pupil_, static_cast<double>(wavenumber), amplitude_.data(), opd_m_.data());
    field_kernels().fold(mixed ? amplitude_.data() : pupil_.amplitude.data(),
                         mixed ? opd_m_.data() : pupil_.opd_m.data(), n, lit_samples_.data(),
                         static_cast<double>(wavenumber), tilt_x_.data(), tilt_y_.data(), terms.data(), fields_,
                         scratch_.data(), even_.data(), odd_.data());
    along_x(even_, cosine_x_, even_middle_);
    along_x(odd_, sine_x_, odd_middle_);
    if (grid_.v_x != 0)
        shear(step * grid_.v_x);
    const Buffer<double> &cosine_y = square ? cosine_x_ : cosine_y_, &sine_y = square ? sine_x_ : sine_y_;
    along_y(even_middle_, 0, cosine_y, ee_);
    along_y(odd_middle_, 0, cosine_y, eo_);
    along_y(even_middle_, 1, sine_y, oe_);
    along_y(odd_middle_, 1, sine_y, oo_);
}

void MatrixDft::accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) noexcept {
    const double *const sums[4] = {ee_.data(), eo_.data(), oe_.data(), oo_.data()};
    field_kernels().accumulate(sums, fields_, grid_.rows, grid_.cols, products.data(), products.size(), scratch_.data(),
                               images);
}

// Replaces each field F_p by H_p = sum over its products of factor weights F_q (twice that for q = p), so that a change
// of the fields changes the sum of the products by Re(sum conj(H_p) dF_p). H is folded: ee, i oe, -i eo and oo become
// its parts even or odd in v (first letter) and u, each summed over the pixels that share |v| and |u|. The middle of an
// odd axis counts once.
void MatrixDft::weight_fields(const std::vector<WeightedProduct> &products) noexcept {
    const size_t rows = grid_.rows, cols = grid_.cols, h = half(rows), w = half(cols);
    UnsetBuffer<double> *const sums[4] = {&ee_, &oe_, &eo_, &oo_};
    for (size_t i = 0; i < h * w; i++) {
        const size_t v = i / w, u = i % w, first = 2 * v * w + u;
        const double once = (rows % 2 != 0 && v == 0 ? 0.5 : 1) * (cols % 2 != 0 && u == 0 ? 0.5 : 1);
        double folded[kMostAdjoint][4][2] = {}; // [field][part as in sums][real, imaginary]
        for (const double s : {-1.0, 1.0})
            for (const double t : {-1.0, 1.0}) {
                const size_t row = s > 0 ? rows - h + v : h - 1 - v, col = t > 0 ? cols - w + u : w - 1 - u;
                Complex field[kMostAdjoint], sum[kMostAdjoint] = {};
                for (size_t f = 0; f < fields_; f++) {
                    const size_t re = f * 2 * h * w + first, im = re + w;
                    field[f] = {ee_[re] + s * oe_[im] + t * (eo_[im] - s * oo_[re]),
                                ee_[im] - s * oe_[re] - t * (eo_[re] + s * oo_[im])};
                }
                for (const WeightedProduct &product : products) {
                    const double weight = once * product.factor * product.weights[row * cols + col];
                    sum[product.p].re += weight * field[product.q].re;
                    sum[product.p].im += weight * field[product.q].im;
                    sum[product.q].re += weight * field[product.p].re;
                    sum[product.q].im += weight * field[product.p].im;
                }
                for (size_t f = 0; f < fields_; f++) {
                    const auto [real, imaginary] = sum[f];
                    auto &parts = folded[f];
                    parts[0][0] += real;
                    parts[0][1] += imaginary;
                    parts[1][0] -= s * imaginary;
                    parts[1][1] += s * real;
                    parts[2][0] += t * imaginary;
                    parts[2][1] -= t * real;
                    parts[3][0] += s * t * real;
                    parts[3][1] += s * t * imaginary;
                }
            }
        for (size_t f = 0; f < fields_; f++)
            for (size_t part = 0; part < 4; part++)
                for (size_t k = 0; k < 2; k++)
                    (*sums[part])[f * 2 * h * w + first + k * w] = folded[f][part][k];
    }
}

// The part of middle that is even (0) or odd (1) in y = operand sums.
void MatrixDft::back_along_y(const Buffer<double> &operand, const UnsetBuffer<double> &sums, size_t part,
                             UnsetBuffer<double> &middle) noexcept {
    const size_t h = half(pupil_.samples), v = half(grid_.rows), width = 2 * half(grid_.cols), tile = tile_rows(v);
    for (size_t field = 0; field < fields_; field++) {
        const double *const from = sums.data() + field * v * width;
        double *const to = middle.data() + field * h * 2 * width + part * width;
        for (size_t y = 0; y < h; y += tile)
            for (size_t j = 0; j < width; j += kTileColumns)
                blas::dgemm(false, std::min(tile, h - y), std::min(kTileColumns, width - j), v, operand.data() + y * v,
                            v, from + j, width, to + 2 * y * width + j, 2 * width);
    }
}

// folded = middle operand^T.
void MatrixDft::back_along_x(const UnsetBuffer<double> &middle, const Buffer<double> &operand,
                             Buffer<double> &folded) noexcept {
    const size_t h = half(pupil_.samples), u = half(grid_.cols), tile = tile_rows(u), rows = fields_ * 4 * h;
    std::fill(folded.begin(), folded.end(), 0.0);
    for (size_t row = 0; row < rows; row += tile)
        for (size_t x = 0; x < h; x += kTileColumns)
            blas::dgemm_add(std::min(tile, rows - row), std::min(kTileColumns, h - x), u, middle.data() + row * u, u,
                            operand.data() + x * u, u, folded.data() + row * h + x, h);
}

// From H_p to its adjoint transforms, in the place of the folded fields.
void MatrixDft::adjoint(long double wavenumber, const std::vector<WeightedProduct> &products) noexcept {
    const bool square = grid_.rows == grid_.cols && grid_.u_x == grid_.v_y;
    const Buffer<double> &cosine_y = square ? cosine_x_ : cosine_y_, &sine_y = square ? sine_x_ : sine_y_;
    weight_fields(products);
    back_along_y(cosine_y, ee_, 0, even_middle_);
    back_along_y(sine_y, oe_, 1, even_middle_);
    back_along_y(cosine_y, eo_, 0, odd_middle_);
    back_along_y(sine_y, oo_, 1, odd_middle_);
    if (grid_.v_x != 0)
        shear(step_of(pupil_, grid_, wavenumber) * grid_.v_x);
    back_along_x(even_middle_, cosine_x_, even_);
    back_along_x(odd_middle_, sine_x_, odd_);
}

// sum over pixels of H exp(+2 pi i (x u + y v)) at a cell, after adjoint().
MatrixDft::Complex MatrixDft::adjoint_at(size_t field, size_t cell) const noexcept {
    const size_t n = pupil_.samples, h = half(n), row = cell / n, col = cell % n;
    const bool up = row >= n - h, right = col >= n - h;
    const size_t y = up ? row - (n - h) : h - 1 - row, x = right ? col - (n - h) : h - 1 - col;
    const double *const even = even_.data() + 4 * (field * h + y) * h + x;
    const double *const odd = odd_.data() + 4 * (field * h + y) * h + x;
    const double s = up ? 1 : -1, t = right ? 1 : -1;
    return {even[0] + s * even[2 * h] - t * (odd[0] + s * odd[2 * h]),
            even[h] + s * even[3 * h] - t * (odd[h] + s * odd[3 * h])};
}

// As a transform needs the samples beyond lit.
void MatrixDft::clear_folded() noexcept {
    for (Buffer<double> *folded : {&even_, &odd_})
        std::fill(folded->begin(), folded->end(), 0.0);
}

void MatrixDft::add_opd_gradient(long double wavenumber, const double *weights, double photons, double *gradient) {
    const size_t n = pupil_.samples;
    const bool mixed = !pupil_.mixed.empty();
    adjoint(wavenumber, {{0, 0, photons, weights}});
    const Buffer<double> &amplitude = mixed ? amplitude_ : pupil_.amplitude, &opd_m = mixed ? opd_m_ : pupil_.opd_m;
    const auto cycles_per_m = static_cast<double>(wavenumber);
    for (size_t i = 0; i < n * n; i++) {
        if (amplitude[i] == 0)
            continue;
        const Complex g = adjoint_at(0, i);
        double cosine, sine;
        kernels::cis_cycles(
            kernels::reduce_cycles(kernels::reduce_cycles(opd_m[i] * cycles_per_m) + tilt_x_[i % n] + tilt_y_[i / n]),
            cosine, sine);
        gradient[i] += 2 * kPi * cycles_per_m * amplitude[i] * (cosine * g.im - sine * g.re);
    }
    clear_folded();
}

// A cell's field is A exp(i k (OPD_0 + tilt)) (1 + c (exp(i k s) - 1)) with the covered fraction c, and that of term p
// is t_p times it: the derivative is Re(sum over p of t_p conj(G_p) dE/dc).
void MatrixDft::add_coverage_gradient(long double wavenumber, const std::vector<kernels::FieldTerm> &terms,
                                      const std::vector<WeightedProduct> &products, double *gradient) noexcept {
    adjoint(wavenumber, products);
    const size_t n = pupil_.samples;
    const auto cycles_per_m = static_cast<double>(wavenumber), middle = 0.5 * (static_cast<double>(n) - 1);
    double half_cosine, half_sine; // exp(i k s) - 1 = 2 i sin(k s/2) exp(i k s/2)
    kernels::cis_cycles(kernels::reduce_cycles(0.5 * pupil_.step_m * cycles_per_m), half_cosine, half_sine);
    for (size_t m = 0; m < pupil_.mixed.size(); m++) {
        const MixedCell &cell = pupil_.mixed[m];
        const size_t i = cell.index;
        const size_t row = i / n, col = i % n;
        const double x = static_cast<double>(col) - middle, y = static_cast<double>(row) - middle;
        const Complex own = adjoint_at(0, i);
        Complex factor[kMostAdjoint] = {{1, 0}}, sum = {own.re, -own.im};
        for (size_t f = 1; f < fields_; f++) {
            const kernels::FieldTerm &term = terms[f - 1];
            const double phase =
                term.slope_x * x + term.slope_y * y + (term.mode != nullptr ? term.mode[i] * term.mode_scale : 0);
            const Complex parent = factor[term.parent], g = adjoint_at(f, i);
            factor[f] = {-phase * parent.im, phase * parent.re};
            sum.re += factor[f].re * g.re + factor[f].im * g.im;
            sum.im += factor[f].im * g.re - factor[f].re * g.im;
        }
        const double opd = pupil_.opd_m[i] - cell.covered * pupil_.step_m;
        double cosine, sine;
        kernels::cis_cycles(
            kernels::reduce_cycles(kernels::reduce_cycles((opd + 0.5 * pupil_.step_m) * cycles_per_m + 0.25) +
                                   tilt_x_[col] + tilt_y_[row]),
            cosine, sine);
        gradient[m] += 2 * half_sine * pupil_.amplitude[i] * (cosine * sum.re - sine * sum.im);
    }
    clear_folded();
}

} // namespace toliman::optics
