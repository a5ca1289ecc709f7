// Adds one sample with nuisance functions to the exact sums of a periodogram, for every frequency of the grid.
#pragma once
#include "kernels/push.hpp"

namespace toliman::kernels {

// After the sums of `Sum`, each nuisance function b has four: C = sum w b cos and S = sum w b sin in units of 2^-50,
// then their remainders in units of 2^-100.
enum FunctionSum { kFunctionC, kFunctionS, kFunctionCLow, kFunctionSLow, kFunctionSums };

struct PushRow {
    double t_high, t_low; // t - t_ref as an unevaluated sum
    double weight;        // in [0, 1]; negative to remove a sample
    size_t functions;     // K, at least 1: the mean and K - 1 nuisance functions
    // [K] y and the values of the K - 1 functions, as unevaluated sums, in [-1, 1].
    const double *value_high, *value_low;
};

struct PushRowsKernels {
    // Given     f0, df, blocks as in PushKernels::push
    // Returned  lo [kSums + (K - 1) kFunctionSums][blocks * kBlock], increased by the sample's terms
    // Notes     The sums of PushKernels::push_double_limb and, for each function, those of FunctionSum. Cosine and sine
    //           are within 2^-97 + 2^-104 |f t| of the exact phase. The same bits on every instruction set.
    void (*push)(double f0, double df, size_t blocks, const PushRow &row, int64_t *const *lo) noexcept;
};
TOLIMAN_ISA_DECLARE(PushRowsKernels, push_rows)

} // namespace toliman::kernels
