// C interface of the direct sums.
#include "kernels/direct.hpp"

using toliman::kernels::DirectKernels;

extern "C" int shim_direct_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

extern "C" void shim_direct(int isa, const double *half_high, const double *half_low, const double *t_high,
                            const double *t_low, const double *w, const double *x, size_t n, double *high,
                            double *low) {
#if defined(__x86_64__)
    const DirectKernels *tables[] = {&toliman::kernels::direct_baseline, &toliman::kernels::direct_avx2,
                                     &toliman::kernels::direct_avx512};
#else
    const DirectKernels *tables[] = {&toliman::kernels::direct_baseline};
#endif
    tables[isa]->direct(half_high, half_low, {t_high, t_low, w, x, n}, high, low);
}
