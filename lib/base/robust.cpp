// Reference: Rousseeuw and Croux 1993, J. Am. Stat. Assoc. 88, 1273
#include "base/robust.hpp"

#include <algorithm>
#include <cmath>

namespace toliman {

double robust_sigma(std::vector<double> residuals) {
    if (residuals.empty())
        return 0;
    for (double &residual : residuals)
        residual = std::fabs(residual);
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    return 1.4826 * *middle;
}

} // namespace toliman
