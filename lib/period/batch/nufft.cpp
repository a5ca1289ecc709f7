// Method: each sample is spread onto the nearest `width` cells of a grid with 2.25 cells per mode by the Kaiser-Bessel
// kernel phi(z) = I_0(beta sqrt(1 - z^2))/I_0(beta), |z| <= 1. A real FFT then gives all modes, and each mode is
// divided by the transform of phi, width sinh(r)/(r I_0(beta)) with r = sqrt(beta^2 - (pi width k/cells)^2) (Fessler
// and Sutton 2003, IEEE Trans. Signal Process. 51, 560).
// The kernel is evaluated as one polynomial of degree width + 3 per cell, as FINUFFT does for its exponential of
// semicircle (Barnett, Magland and af Klinteberg 2019, SIAM J. Sci. Comput. 41, C479). So Bessel functions cost nothing
// per sample, and the transform has a closed form.
// Error: measured bounds per width, from 1.3e-4 (5 cells) to 1.6e-14 (15 cells); tested by tests/kernel/test_spread.c.
#include "period/batch/nufft.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/constants.hpp"

namespace toliman::period {

namespace {

constexpr long double kOversampling = 2.25L; // cells per mode
constexpr long double kSharpness =
    0.985L * (1 - 1 / (2 * kOversampling)); // beta/(pi width): near the minimum of the error

// Largest error of a sum relative to the sum of |weights|, rounding included; measured, tested by
// tests/kernel/test_spread.c.
struct Width {
    size_t width, lanes;
    double error;
};
constexpr Width kWidths[] = {{5, 8, 1.3e-4},    {7, 8, 1.1e-6},    {9, 12, 1.2e-8},
                             {11, 12, 1.3e-10}, {13, 16, 1.3e-12}, {15, 16, 1.6e-14}};

// Returns the smallest even number >= n without a prime factor above 5: FFTW is fast for these sizes.
size_t smooth_size(size_t n) noexcept {
    for (n += n % 2;; n += 2) {
        size_t rest = n;
        for (size_t prime : {size_t{2}, size_t{3}, size_t{5}})
            while (rest % prime == 0)
                rest /= prime;
        if (rest == 1)
            return n;
    }
}

// The modified Bessel function I_0(sqrt(square)), by its power series.
long double bessel(long double square) noexcept {
    long double sum = 1, term = 1;
    for (int k = 1; term > sum * 1e-22L; k++) {
        term *= square / 4 / (static_cast<long double>(k) * k);
        sum += term;
    }
    return sum;
}

// cos(pi m/(2 n)) for m = 0 ... 4 n - 1: all that polynomial() needs of n points.
std::vector<long double> chebyshev_cosines(size_t n) {
    std::vector<long double> cosines(4 * n);
    for (size_t m = 0; m < cosines.size(); m++)
        cosines[m] = std::cos(kLongPi * static_cast<long double>(m) / static_cast<long double>(2 * n));
    return cosines;
}

// Coefficients of the polynomial of this degree that interpolates f at the Chebyshev points of [-1, 1].
template <class Function>
std::vector<long double> polynomial(size_t degree, const std::vector<long double> &cosines, Function f) {
    const size_t n = degree + 1;
    std::vector<long double> values(n), sum(n), chebyshev(n), before(n);
    for (size_t j = 0; j < n; j++)
        values[j] = f(cosines[2 * j + 1]);
    chebyshev[0] = 1; // coefficients of T_0, then T_1, ...
    for (size_t order = 0; order < n; order++) {
        long double share = 0;
        for (size_t j = 0; j < n; j++)
            share += values[j] * cosines[order * (2 * j + 1) % (4 * n)];
        share *= (order == 0 ? 1.0L : 2.0L) / static_cast<long double>(n);
        for (size_t power = 0; power < n; power++)
            sum[power] += share * chebyshev[power];
        for (size_t power = n; power-- > 0;) { // T_{m+1} = 2 x T_m - T_{m-1}
            const long double raised = power > 0 ? chebyshev[power - 1] : 0;
            before[power] = (order == 0 ? 1.0L : 2.0L) * raised - before[power];
        }
        std::swap(before, chebyshev);
    }
    return sum;
}

} // namespace

Nufft::Choice Nufft::choose(size_t modes, double error) noexcept {
    const Width *found = std::find_if(std::begin(kWidths), std::end(kWidths) - 1,
                                      [&](const Width &width) { return width.error <= error; });
    const size_t min_cells = 2 * kernels::kSpreadLanes; // so that a kernel does not overlap itself
    const auto cells = static_cast<size_t>(kOversampling * static_cast<long double>(modes)) + 1;
    return {modes, smooth_size(std::max(cells, min_cells)), found->width, found->lanes, found->error};
}

Nufft::Nufft(const Choice &choice)
    : choice_(choice), shape_{choice.width, choice.lanes, choice.width + 3, nullptr}, fft_(choice.cells) {
    const long double beta = kSharpness * kLongPi * static_cast<long double>(choice.width);
    make_coefficients(beta);
    make_corrections(beta);
}

void Nufft::make_coefficients(long double beta) {
    const auto width = static_cast<long double>(shape_.width);
    coefficients_.resize((shape_.degree + 1) * shape_.lanes);
    const std::vector<long double> cosines = chebyshev_cosines(shape_.degree + 1);
    const long double peak = bessel(beta * beta);
    for (size_t cell = 0; cell < shape_.width; cell++) {
        const long double left = static_cast<long double>(cell) - (width - 1) / 2;
        const auto row = polynomial(shape_.degree, cosines, [&](long double s) {
            const long double z = 2 * (left + s / 2) / width;
            return bessel(beta * beta * (1 - z * z)) / peak;
        });
        for (size_t power = 0; power <= shape_.degree; power++)
            coefficients_[power * shape_.lanes + cell] = static_cast<double>(row[power]);
    }
    shape_.coefficients = coefficients_.data();
}

// The transform of the kernel is width sinh(r)/(r I_0(beta)). sinh(r) is taken as
// exp(r)/2: with r > 10 the relative error exp(-2 r) is far below that of the kernel.
void Nufft::make_corrections(long double beta) {
    const long double width = static_cast<long double>(shape_.width),
                      step = kLongPi * width / static_cast<long double>(choice_.cells);
    const auto scale = static_cast<double>(2 * bessel(beta * beta) / std::exp(beta) / width);
    corrections_.resize(choice_.modes / 2 + 1);
    for (size_t k = 0; k <= choice_.modes / 2; k++) {
        const auto place = static_cast<double>(step * static_cast<long double>(k)), sharp = static_cast<double>(beta);
        const double r = std::sqrt((sharp - place) * (sharp + place));
        // beta - r = place^2/(beta + r), without cancellation
        corrections_[k] = scale * r * std::exp(place * place / (sharp + r));
    }
}

void Nufft::spread(const kernels::SpreadSamples &samples, double df, double f_high, double f_low, size_t pairs,
                   double *const *grids) const noexcept {
    kernels::spread_kernels().spread(samples, shape_, {df, f_high, f_low, static_cast<double>(choice_.cells)}, pairs,
                                     grids);
    for (size_t g = 0; g < 2 * pairs; g++)
        for (size_t i = 0; i < kernels::kSpreadLanes; i++)
            grids[g][i] += grids[g][choice_.cells + i];
}

void Nufft::transform(double *grid) const noexcept {
    fft_.transform(grid);
}

// The FFT of a real grid has the sign exp(-i ...) and holds modes >= 0 only; negative modes are the complex conjugates.
std::complex<double> Nufft::sum(const double *cosines, const double *sines, size_t k) const noexcept {
    const bool below = k < choice_.modes / 2;
    const size_t mode = below ? choice_.modes / 2 - k : k - choice_.modes / 2;
    const double sign = below ? 1 : -1, correction = corrections_[mode];
    const double a = cosines[2 * mode], b = sign * cosines[2 * mode + 1];
    const double c = sines[2 * mode], d = sign * sines[2 * mode + 1];
    return {(a - d) * correction, (b + c) * correction};
}

} // namespace toliman::period
