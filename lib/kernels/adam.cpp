// Bias corrections of Adam's moments, in double, once per step; the update of the weights is in adam.isa.cpp.
#include "kernels/adam.hpp"

#include <cmath>

namespace toliman::kernels {

void adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
          float *weights) noexcept {
    const double age = static_cast<double>(step);
    adam_kernels().update(static_cast<float>(rate / (1 - std::pow(0.9, age))),
                          static_cast<float>(1 / (1 - std::pow(0.999, age))), gradient, count, mean, square, weights);
}

} // namespace toliman::kernels
