// C interface of the push kernel for samples with nuisance functions, each instruction set by number.
#include "isa_tables.hpp"
#include "kernels/push_rows.hpp"

using namespace toliman::kernels;

extern "C" {

// sample = {t_high, t_low, weight}; lo is [14 + 4 (functions - 1)][blocks * 64].
void shim_push_rows(int isa, double f0, double df, size_t blocks, const double *sample, size_t functions,
                    const double *high, const double *low, int64_t *lo) {
    int64_t *rows[64] = {};
    for (size_t i = 0; i < kSums + (functions - 1) * kFunctionSums; i++)
        rows[i] = lo + i * blocks * kBlock;
    KERNELS(push_rows, isa).push(f0, df, blocks, {sample[0], sample[1], sample[2], functions, high, low}, rows);
}
}
