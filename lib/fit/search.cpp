// Method: correlation of the square roots of counts and expected counts, whose noise is the same in all pixels, with
// their means subtracted, by Fourier transforms of both at once (as real and imaginary part). The maximum over whole
// pixels is refined along each axis by a parabola through its neighbours, to about 0.1 px.
#include "fit/search.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace toliman::fit {

namespace {

double root(double counts, double bias) noexcept {
    return std::sqrt(std::max(0.0, counts - bias));
}

// Offset of the maximum of the parabola through (-1, below), (0, middle), (1, above).
double vertex(double below, double middle, double above) noexcept {
    const double curve = below - 2 * middle + above;
    return curve < 0 ? std::clamp(0.5 * (below - above) / curve, -0.5, 0.5) : 0;
}

} // namespace

Search::Search(size_t rows, size_t cols, double reach)
    : rows_(rows), cols_(cols), side_(fft::fast_size(std::max(rows, cols) + static_cast<size_t>(std::ceil(reach)) + 1)),
      reach_(static_cast<long>(reach)), transform_(side_) {}

std::array<double, 2> Search::shift(ImageView<const double> counts, ImageView<const double> expected,
                                    double bias) noexcept {
    std::complex<double> *const data = transform_.data();
    std::complex<double> mean = 0;
    for (size_t r = 0; r < rows_; r++)
        for (size_t c = 0; c < cols_; c++)
            mean += std::complex<double>(root(counts.row(r)[c], bias), root(expected.row(r)[c], bias));
    mean /= static_cast<double>(rows_ * cols_);
    std::fill_n(data, side_ * side_, 0);
    for (size_t r = 0; r < rows_; r++)
        for (size_t c = 0; c < cols_; c++)
            data[r * side_ + c] =
                std::complex<double>(root(counts.row(r)[c], bias), root(expected.row(r)[c], bias)) - mean;
    transform_.transform();
    // With Z = D + i T of real images, conj(D) T at frequency k and its conjugate at -k.
    for (size_t i = 0; i < side_ * side_; i++) {
        const size_t row = i / side_, col = i % side_;
        const size_t j = (side_ - row) % side_ * side_ + (side_ - col) % side_;
        if (j < i)
            continue;
        const std::complex<double> z = data[i], other = std::conj(data[j]);
        const std::complex<double> d = 0.5 * (z + other), t = std::complex<double>(0, -0.5) * (z - other);
        data[i] = std::conj(d) * t;
        data[j] = std::conj(data[i]);
    }
    transform_.transform();
    const auto at = [&](long y, long x) {
        const long side = static_cast<long>(side_);
        return data[static_cast<size_t>((y + side) % side) * side_ + static_cast<size_t>((x + side) % side)].real();
    };
    long best_x = 0, best_y = 0;
    for (long y = -reach_; y <= reach_; y++)
        for (long x = -reach_; x <= reach_; x++)
            if (at(y, x) > at(best_y, best_x)) {
                best_x = x;
                best_y = y;
            }
    const double middle = at(best_y, best_x);
    return {static_cast<double>(best_x) + vertex(at(best_y, best_x - 1), middle, at(best_y, best_x + 1)),
            static_cast<double>(best_y) + vertex(at(best_y - 1, best_x), middle, at(best_y + 1, best_x))};
}

} // namespace toliman::fit
