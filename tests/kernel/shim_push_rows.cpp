// C interface of the push kernel for samples with nuisance functions, each instruction set by number.
#include "kernels/push_rows.hpp"

using namespace toliman::kernels;

namespace {
const PushRowsKernels *const tables[] = {
    &push_rows_baseline,
#if defined(__x86_64__)
    &push_rows_avx2,
    &push_rows_avx512,
#endif
};
} // namespace

extern "C" {

int shim_push_rows_isas(void) {
    return static_cast<int>(host_isa()) + 1;
}

// sample = {t_high, t_low, weight}; lo is [14 + 4 (functions - 1)][blocks * 64].
void shim_push_rows(int isa, double f0, double df, size_t blocks, const double *sample, size_t functions,
                    const double *high, const double *low, int64_t *lo) {
    int64_t *rows[64] = {};
    for (size_t i = 0; i < kSums + (functions - 1) * kFunctionSums; i++)
        rows[i] = lo + i * blocks * kBlock;
    tables[isa]->push(f0, df, blocks, {sample[0], sample[1], sample[2], functions, high, low}, rows);
}
}
