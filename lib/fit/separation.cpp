#include "fit/separation.hpp"

#include <cmath>

namespace toliman::fit {

double separation_of(const double *values) noexcept {
    return std::hypot(values[x_b] - values[x_a], values[y_b] - values[y_a]);
}

SeparationAxis separation_axis(const State &state, size_t parameters) noexcept {
    const double *const values = state.values, separation = separation_of(values),
                        x = (values[x_b] - values[x_a]) / separation, y = (values[y_b] - values[y_a]) / separation;
    const double gradient[4] = {-x, -y, x, y}; // by the places, from x_a on
    SeparationAxis axis = {};
    for (size_t i = 0; i < parameters; i++)
        for (size_t j = x_a; j <= y_b; j++)
            axis.change[i] += state.covariance[i * parameters + j] * gradient[j];
    for (size_t j = x_a; j <= y_b; j++)
        axis.variance_px2 += axis.change[j] * gradient[j];
    for (size_t i = 0; i < parameters; i++)
        axis.change[i] /= axis.variance_px2;
    const auto variance = [&](size_t i) { return state.covariance[i * parameters + i]; };
    const double of_a = variance(x_a) + variance(y_a), of_b = variance(x_b) + variance(y_b);
    axis.share_b = of_b / (of_a + of_b);
    return axis;
}

} // namespace toliman::fit
