// C interface of the power kernel.
#include "isa_tables.hpp"
#include "kernels/power.hpp"

extern "C" size_t shim_power(int isa, int double_limb, const int64_t *const *lo, const int64_t *const *hi, size_t n,
                             double weight, int64_t samples, double mean_high, double mean_low, double spread,
                             int fixed_mean, double *power) {
    return (double_limb ? KERNELS(power, isa).power_double_limb : KERNELS(power, isa).power)(
        lo, hi, n, {weight, samples, mean_high, mean_low, spread, fixed_mean != 0}, power);
}

extern "C" int shim_any_reaches(int isa, const double *values, size_t n, double limit) {
    return KERNELS(power, isa).any_reaches(values, n, limit) ? 1 : 0;
}
