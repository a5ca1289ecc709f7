// C interface of the direct sums.
#include "isa_tables.hpp"
#include "kernels/direct.hpp"

extern "C" void shim_direct(int isa, const double *half_high, const double *half_low, const double *t_high,
                            const double *t_low, const double *w, const double *x, size_t n, double *high,
                            double *low) {
    KERNELS(direct, isa).direct(half_high, half_low, {t_high, t_low, w, x, n}, high, low);
}
