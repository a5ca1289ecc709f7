// One step of the Adam optimiser, float32.
#pragma once
#include <cstddef>

namespace toliman::kernels {

// Given     gradient, weights [count]; mean, square [count], the running moments, zero before step 1; rate > 0
// Returned  weights, mean, square of after step number `step`
// Reference Kingma and Ba (2015), beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8
void adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
          float *weights) noexcept;

} // namespace toliman::kernels
