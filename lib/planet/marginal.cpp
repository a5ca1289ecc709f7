// Method: shapes X, whitened, about the orthonormal functions Q: S = X^T X - (Q^T X)^T (Q^T X), b = X^T r with the
// residuals r of the values, which are orthogonal to Q. With amplitudes of prior N(0, s^2 I),
//     ln BF = b^T (S + I/s^2)^-1 b/2 - ln det(S + I/s^2)/2 - m ln s.
// Reference: Price-Whelan et al. (2017), ApJ 837, 20
#include "planet/marginal.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "kernels/kepler_rows.hpp"

namespace toliman::planet {

Moments ShapeWork::moments(const Series &series, const Design &design, const Orbit &orbit) {
    const size_t m = series.amplitudes(), rows = series.rows, k = design.functions();
    const kernels::KeplerKernels &kernel = kernels::kepler_kernels();
    if (!(orbit == orbit_)) {
        set_shapes(series, orbit, shapes_.data());
        orbit_ = orbit;
    }
    const double *const weights = design.weights().data();
    double *const x = weighted_.data();
    for (size_t i = 0; i < m; i++)
        for (size_t row = 0; row < rows; row++)
            x[i * rows + row] = weights[row] * shapes_[i * rows + row];
    products_.resize((k + 1 + m) * m);
    Moments moments = {};
    moments.size = m;
    for (size_t pair = 0; pair < m; pair += 2) {
        double *const along = products_.data() + pair * (k + 1 + m);
        kernel.products(design.table(), k + 1, x + pair * rows, x + (pair + 1) * rows, rows, along);
        kernel.products(x, m, x + pair * rows, x + (pair + 1) * rows, rows, along + 2 * (k + 1));
    }
    const auto product = [&](size_t row, size_t shape) {
        return products_[(shape / 2) * 2 * (k + 1 + m) + 2 * row + shape % 2];
    };
    for (size_t i = 0; i < m; i++) {
        moments.right[i] = product(k, i);
        for (size_t j = 0; j <= i; j++) {
            double sum = product(k + 1 + j, i);
            for (size_t q = 0; q < k; q++)
                sum -= product(q, i) * product(q, j);
            moments.matrix[i][j] = sum;
        }
    }
    return moments;
}

namespace {

// With the Cholesky factor L L^T = S + I/s^2: solved = L^-1 b, mean = L^-T solved, volume = s^m det L, so that
// ln BF = |solved|^2/2 - ln volume. The eigenvalues of S + I/s^2, and so its pivots, are at least 1/s^2: what rounding
// leaves below is raised to it.
template <size_t m> [[gnu::always_inline]] inline AmplitudeFit fit_of(const Moments &moments, double scale) noexcept {
    const double precision = 1 / (scale * scale);
    AmplitudeFit fit = {};
    double volume = 1, square = 0, solved[kMostAmplitudes] = {};
    for (size_t i = 0; i < m; i++) {
        double diagonal = std::max(moments.matrix[i][i], 0.0) + precision, right = moments.right[i];
        for (size_t j = 0; j < i; j++) {
            double sum = moments.matrix[i][j];
            for (size_t l = 0; l < j; l++)
                sum -= fit.factor[i][l] * fit.factor[j][l];
            fit.factor[i][j] = sum / fit.factor[j][j];
            diagonal -= fit.factor[i][j] * fit.factor[i][j];
            right -= fit.factor[i][j] * solved[j];
        }
        fit.factor[i][i] = std::sqrt(std::max(diagonal, precision));
        solved[i] = right / fit.factor[i][i];
        square += solved[i] * solved[i];
        volume *= fit.factor[i][i] * scale;
    }
    for (size_t i = m; i-- > 0;) {
        double sum = solved[i];
        for (size_t j = i + 1; j < m; j++)
            sum -= fit.factor[j][i] * fit.mean[j];
        fit.mean[i] = sum / fit.factor[i][i];
    }
    fit.log_bayes = square / 2 - std::log(volume);
    return fit;
}

// Calls work with the number of amplitudes as a constant, by which the compiler unrolls its loops.
template <class Work> auto with_size(size_t m, Work work) noexcept {
    static_assert(kMostAmplitudes == 6);
    return m == 2   ? work(std::integral_constant<size_t, 2>())
           : m == 4 ? work(std::integral_constant<size_t, 4>())
                    : work(std::integral_constant<size_t, 6>());
}

} // namespace

AmplitudeFit fit_amplitudes(const Moments &moments, double scale) noexcept {
    return with_size(moments.size, [&](auto m) { return fit_of<m>(moments, scale); });
}

double log_bayes(const Moments &moments, const std::vector<double> &scales, double *each) noexcept {
    return with_size(moments.size, [&](auto m) {
        double largest = -HUGE_VAL, sum = 0; // of exp(value - largest), so that none overflows
        for (size_t i = 0; i < scales.size(); i++) {
            const double value = fit_of<m>(moments, scales[i]).log_bayes;
            if (each != nullptr)
                each[i] = value;
            if (value > largest) {
                sum = sum * std::exp(largest - value) + 1;
                largest = value;
            } else {
                sum += std::exp(value - largest);
            }
        }
        return largest + std::log(sum / static_cast<double>(scales.size()));
    });
}

} // namespace toliman::planet
