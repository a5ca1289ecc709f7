// C interface of the power kernel.
#include "kernels/power.hpp"

using toliman::kernels::PowerKernels;

extern "C" int shim_power_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

static const PowerKernels &table(int isa) {
#if defined(__x86_64__)
    const PowerKernels *const tables[] = {&toliman::kernels::power_baseline, &toliman::kernels::power_avx2,
                                          &toliman::kernels::power_avx512};
#else
    const PowerKernels *const tables[] = {&toliman::kernels::power_baseline};
#endif
    return *tables[isa];
}

extern "C" size_t shim_power(int isa, int double_limb, const int64_t *const *lo, const int64_t *const *hi, size_t n,
                             double weight, int64_t samples, double mean_high, double mean_low, double spread,
                             int fixed_mean, double *power) {
    return (double_limb ? table(isa).power_double_limb : table(isa).power)(
        lo, hi, n, {weight, samples, mean_high, mean_low, spread, fixed_mean != 0}, power);
}

extern "C" int shim_any_reaches(int isa, const double *values, size_t n, double limit) {
    return table(isa).any_reaches(values, n, limit) ? 1 : 0;
}
