// Reference: Rousseeuw and Croux 1993, J. Am. Stat. Assoc. 88, 1273
#include "base/robust.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace toliman {

double median(std::vector<double> values) {
    if (values.empty())
        return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double robust_sigma(std::vector<double> residuals) {
    for (double &residual : residuals)
        residual = std::fabs(residual);
    return 1.4826 * median(std::move(residuals));
}

} // namespace toliman
