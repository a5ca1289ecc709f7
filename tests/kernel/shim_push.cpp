// C interface of the periodogram's push kernels, each instruction set by number.
#include "isa_tables.hpp"
#include "kernels/push.hpp"
#include "kernels/push_rows.hpp"

using namespace toliman::kernels;

extern "C" {

// sample = {t_high, t_low, weight, value_high, value_low}; lo is [8][blocks * 64], or [14][...] if double-limb.
void shim_push(int isa, int double_limb, double f0, double df, size_t blocks, const double *sample, double *anchors,
               int64_t *lo) {
    int64_t *rows[kSums] = {};
    for (size_t i = 0; i < (double_limb ? size_t{kSums} : kSingleLimbSums); i++)
        rows[i] = lo + i * blocks * kBlock;
    (double_limb ? KERNELS(push, isa).push_double_limb : KERNELS(push, isa).push)(
        f0, df, blocks, {sample[0], sample[1], sample[2], sample[3], sample[4]}, anchors, rows);
}

void shim_fold(int isa, int64_t *lo, int64_t *hi, size_t n) {
    KERNELS(push, isa).fold(lo, hi, n);
}

void shim_cis(int isa, double f_high, double f_low, double t_high, double t_low, double *cosine, double *sine) {
    KERNELS(push, isa).cis(f_high, f_low, t_high, t_low, cosine, sine);
}

// sample = {t_high, t_low, weight}; lo is [14 + 4 (functions - 1)][blocks * 64].
void shim_push_rows(int isa, double f0, double df, size_t blocks, const double *sample, size_t functions,
                    const double *high, const double *low, int64_t *lo) {
    int64_t *rows[64] = {};
    for (size_t i = 0; i < kSums + (functions - 1) * kFunctionSums; i++)
        rows[i] = lo + i * blocks * kBlock;
    KERNELS(push_rows, isa).push(f0, df, blocks, {sample[0], sample[1], sample[2], functions, high, low}, rows);
}
}
