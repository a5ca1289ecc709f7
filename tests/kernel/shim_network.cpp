// C interface of the Adam step, ELU, the decorrelation and the structural similarity.
#include <vector>

#include "isa_tables.hpp"
#include "kernels/adam.hpp"
#include "kernels/decorrelate.hpp"
#include "kernels/elu.hpp"
#include "kernels/ssim.hpp"

extern "C" void shim_adam(size_t step, double rate, const float *gradient, size_t count, float *mean, float *square,
                          float *weights) {
    toliman::kernels::adam(step, rate, gradient, count, mean, square, weights);
}

extern "C" void shim_elu(int isa, float *values, size_t count) {
    KERNELS(elu, isa).elu(values, count);
}

extern "C" void shim_decorrelate(int isa, float *samples, size_t n, size_t count, float *work) {
    KERNELS(decorrelate, isa).decorrelate(samples, n, count, work);
}

extern "C" double shim_ssim(const double *a, const double *b, size_t rows, size_t cols) {
    std::vector<double> scratch(5 * cols);
    return toliman::kernels::mean_ssim(a, b, rows, cols, scratch.data());
}
