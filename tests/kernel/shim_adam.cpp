// C interface of the Adam step, for test_adam.c.
#include "kernels/adam.hpp"

extern "C" void shim_adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
                          float *weights) {
    toliman::kernels::adam(step, rate, gradient, count, mean, square, weights);
}
