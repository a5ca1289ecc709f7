// Method: chi-square per degree of freedom of a right model has mean 1 and standard deviation s, and is nearly
// chi-square distributed with 2/s^2 degrees of freedom. Its cube root is nearly Gaussian, with mean 1 - s^2/9 and
// standard deviation s/3, so that the quantile of z standard deviations is (1 - s^2/9 + z s/3)^3: within 1 % of the
// exact one for 10 degrees of freedom and 6 standard deviations, where 1 + z s is too low by a third.
// The variance of the square of a Poisson residual, (n - m)^2/m, is 2 + 1/m.
// Reference: Wilson and Hilferty 1931, Proc. Natl. Acad. Sci. 17, 684.
#include "base/goodness.hpp"

#include <algorithm>
#include <cmath>

namespace toliman {

const char *name_of(GoodnessVerdict verdict) noexcept {
    static const char *const names[] = {"unknown", "good", "poor", "too good"};
    return names[static_cast<size_t>(verdict)];
}

double chi_square_quantile(double sigma, double sigmas) noexcept {
    const double root = std::max(0.0, 1 - sigma * sigma / 9 + sigmas * sigma / 3);
    return root * root * root;
}

double chi_square_sigma(size_t used, double inverse_counts, double freedom) noexcept {
    return std::sqrt(2 * static_cast<double>(used) + inverse_counts) / freedom;
}

GoodnessVerdict judge(double chi_square, double sigma, double sigmas) noexcept {
    if (std::isnan(chi_square) || std::isnan(sigma))
        return GoodnessVerdict::unknown;
    return chi_square > chi_square_quantile(sigma, sigmas)    ? GoodnessVerdict::poor
           : chi_square < chi_square_quantile(sigma, -sigmas) ? GoodnessVerdict::too_good
                                                              : GoodnessVerdict::good;
}

} // namespace toliman
