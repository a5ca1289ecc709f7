// C interface of the structural similarity.
#include <vector>

#include "kernels/ssim.hpp"

extern "C" double shim_ssim(const double *a, const double *b, size_t rows, size_t cols) {
    std::vector<double> scratch(5 * cols);
    return toliman::kernels::mean_ssim(a, b, rows, cols, scratch.data());
}
