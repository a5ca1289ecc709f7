// C interface of the power kernels, and of the sums of samples with nuisance functions.
#include "isa_tables.hpp"
#include "kernels/power.hpp"
#include "kernels/power_rows.hpp"

using namespace toliman::kernels;

extern "C" size_t shim_power(int isa, int double_limb, const int64_t *const *lo, const int64_t *const *hi, size_t n,
                             double weight, int64_t samples, double mean_high, double mean_low, double spread,
                             int fixed_mean, double *power) {
    return (double_limb ? KERNELS(power, isa).power_double_limb : KERNELS(power, isa).power)(
        lo, hi, n, {weight, samples, mean_high, mean_low, spread, fixed_mean != 0}, power);
}

extern "C" int shim_any_reaches(int isa, const double *values, size_t n, double limit) {
    return KERNELS(power, isa).any_reaches(values, n, limit) ? 1 : 0;
}

extern "C" {

// sample = {t, weight}, values [functions]; lo is [14 + 4 (functions - 1)][blocks * 64].
void shim_add_row(double f0, double df, size_t blocks, const double *sample, size_t functions, const double *values,
                  int64_t *lo) {
    const double low[kMaxRows] = {};
    int64_t *rows[kSums + (kMaxRows - 1) * kFunctionSums] = {};
    for (size_t i = 0; i < kSums + (functions - 1) * kFunctionSums; i++)
        rows[i] = lo + i * blocks * kBlock;
    push_rows_baseline.push(f0, df, blocks, {sample[0], 0, sample[1], functions, values, low}, rows);
}

// sums = {W, root mean square of y, spread}; factor is [functions][functions].
size_t shim_power_rows(int isa, const int64_t *const *lo, const int64_t *const *hi, size_t n, int64_t samples,
                       const double *sums, size_t functions, const double *factor, const double *y, double *power) {
    PowerRowsShared shared = {};
    shared.weight = sums[0];
    shared.samples = samples;
    shared.size = sums[1];
    shared.spread = sums[2];
    shared.used = functions;
    for (size_t i = 0; i < functions; i++) {
        shared.function[i] = i;
        for (size_t j = 0; j < i; j++)
            shared.factor[i][j] = factor[i * functions + j];
        shared.inverse[i] = 1 / factor[i * functions + i];
        shared.y[i] = y[i];
    }
    return KERNELS(power_rows, isa).power(lo, hi, n, shared, power);
}
}
