// Method: with weighted means, variances and covariance of x and y under an 11x11 Gaussian window,
//     SSIM = (2 mx my + C1)(2 cov + C2)/((mx^2 + my^2 + C1)(vx + vy + C2)),    C1 = 0.01^2, C2 = 0.03^2
// averaged over pixels. The window is separable: five moments are summed down the columns, then along the rows.
// Reference: Wang, Bovik, Sheikh and Simoncelli (2004), IEEE Trans. Image Processing 13, 600.
#include "kernels/ssim.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

constexpr size_t kWindow = 11;
constexpr size_t kMoments = 5; // a, b, a a, b b, a b

void gaussian_window(double *window) noexcept {
    double sum = 0;
    for (size_t i = 0; i < kWindow; i++) {
        const double x = (static_cast<double>(i) - 5) / 1.5;
        sum += window[i] = std::exp(-x * x / 2);
    }
    for (size_t i = 0; i < kWindow; i++)
        window[i] /= sum;
}

// The five weighted moments of each column over the window's eleven rows.
void column_moments(const double *window, const double *a, const double *b, size_t cols, double *moments) noexcept {
    for (size_t i = 0; i < kMoments * cols; i++)
        moments[i] = 0;
    for (size_t r = 0; r < kWindow; r++)
        for (size_t c = 0; c < cols; c++) {
            const double x = a[r * cols + c], y = b[r * cols + c];
            moments[c] += window[r] * x;
            moments[cols + c] += window[r] * y;
            moments[2 * cols + c] += window[r] * x * x;
            moments[3 * cols + c] += window[r] * y * y;
            moments[4 * cols + c] += window[r] * x * y;
        }
}

double similarity(const double *mean) noexcept {
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    const double x = mean[0], y = mean[1];
    const double variance = (mean[2] - x * x) + (mean[3] - y * y), covariance = mean[4] - x * y;
    return (2 * x * y + kC1) * (2 * covariance + kC2) / ((x * x + y * y + kC1) * (variance + kC2));
}

} // namespace

double mean_ssim(const double *a, const double *b, size_t rows, size_t cols, double *scratch) noexcept {
    double window[kWindow];
    gaussian_window(window);
    double sum = 0;
    for (size_t r = 0; r + kWindow <= rows; r++) {
        column_moments(window, a + r * cols, b + r * cols, cols, scratch);
        double row_sum = 0;
        for (size_t c = 0; c + kWindow <= cols; c++) {
            double mean[kMoments] = {};
            for (size_t m = 0; m < kMoments; m++)
                for (size_t i = 0; i < kWindow; i++)
                    mean[m] += window[i] * scratch[m * cols + c + i];
            row_sum += similarity(mean);
        }
        sum += row_sum;
    }
    return sum / static_cast<double>((rows - kWindow + 1) * (cols - kWindow + 1));
}

} // namespace toliman::kernels
