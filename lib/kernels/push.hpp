// Adds one sample to the exact sums of a periodogram, for every frequency of the grid.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// Fixed-point accumulators in carry-save form, value = hi 2^32 + lo. A push adds a term of at most 2^50 to lo only;
// after at most kFoldEvery pushes fold() moves the upper part of lo into hi. Integer addition is associative, so that
// any order of pushes gives the same bits and a sample can be removed exactly.
//
// A single-limb accumulator has the first eight sums: one limb (units of 2^-50) for weights, two (2^-50 and 2^-100) for
// values. A double-limb accumulator has one more limb of each, for samples whose weights differ by orders of magnitude.
enum Sum { kC1, kS1, kC2, kS2, kYC, kYS, kYCLow, kYSLow, kC1Low, kS1Low, kC2Low, kS2Low, kYCLowest, kYSLowest, kSums };
constexpr size_t kSingleLimbSums = kC1Low;
constexpr int kFoldEvery = 4096;
constexpr size_t kBlock = 64;   // frequencies that share one anchor; arrays are padded to a multiple
constexpr double kOne = 0x1p50; // fixed-point representation of 1, for weights and for values in units of their bound
constexpr int64_t kFoldBase = 1ll << 32;

struct PushSample {
    double t_high, t_low; // t - t_ref as an unevaluated sum
    double weight;        // in [0, 1]; negative to remove a sample
    double value_high;    // (y - offset)/bound as an unevaluated sum, in [-1, 1]
    double value_low;
};

struct PushKernels {
    // Given     f0, df, the grid f_k = f0 + k df as exact reals (cycles per unit of t)
    //           blocks, number of kBlock-wide blocks; anchors [2][blocks] scratch
    // Returned  lo [kSingleLimbSums][blocks * kBlock], increased by the sample's terms
    // Notes     With phase p_k = f_k (t - t_ref) reduced modulo 1 exactly, c = cos 2 pi p, s = sin 2 pi p:
    //           C1 += w c, S1 += w s, C2 += w cos 4 pi p, S2 += w sin 4 pi p, YC += w y c, YS += w y s, quantised to
    //           2^-50; the remainder of the last two goes to YCLow, YSLow at 2^-100. c and s are within 4e-16.
    //           Uses only +, -, * and exact products: the same bits on every instruction set.
    void (*push)(double f0, double df, size_t blocks, const PushSample &sample, double *anchors,
                 int64_t *const *lo) noexcept;

    // The same with lo [kSums][...]: the remainders of C1, S1, C2, S2 go to their Low limb at 2^-100, those of YCLow,
    // YSLow to YCLowest, YSLowest at 2^-150.
    // Notes     All terms derive from one point (c, s) that is within 4e-16 of the phase and on the unit circle to
    //           2^-100. The error of a dominant sample is then a small shift of its phase. Otherwise it would violate
    //           c^2 + s^2 = 1 and mask the contributions of all lighter samples.
    void (*push_double_limb)(double f0, double df, size_t blocks, const PushSample &sample, double *anchors,
                             int64_t *const *lo) noexcept;

    // Moves the upper part of lo into hi.
    // Given     lo, hi [n]
    // Returned  the same values, with 0 <= lo < 2^32
    void (*fold)(int64_t *lo, int64_t *hi, size_t n) noexcept;

    // Given     f = f_high + f_low, t = t_high + t_low
    // Returned  cosine and sine of 2 pi f t, within 2e-16
    void (*cis)(double f_high, double f_low, double t_high, double t_low, double *cosine, double *sine) noexcept;
};
TOLIMAN_ISA_DECLARE(PushKernels, push)

} // namespace toliman::kernels
