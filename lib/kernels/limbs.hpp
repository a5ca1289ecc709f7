// Rounding of terms to the limbs of the accumulators of kernels/push.hpp.
//
// All functions are static, so that each file keeps the copy of its own instruction set (kernels/isa.hpp).
#pragma once

#include "kernels/pair.hpp"
#include "kernels/push.hpp"

namespace toliman::kernels {

// Nearest integer to x, |x| < 2^51, ties to even; an odd function, so that a removed sample cancels exactly.
static inline uint64_t quantised(double x) noexcept {
    const double shifted = x + 0x1.8p52; // the integer is in the low bits
    uint64_t bits;
    __builtin_memcpy(&bits, &shifted, sizeof bits);
    return bits - 0x4338000000000000u;
}

// Splits a term into two limbs, which quantised() rounds, and returns the remainder in units of a third.
static inline double split_limbs(Pair term, double &high, double &low) noexcept {
    const Pair remainder = difference(term.value - nearest_whole(term.value), -term.error);
    high = term.value;
    low = remainder.value * kOne;
    return ((low - nearest_whole(low)) + remainder.error * kOne) * kOne;
}

// Adds a term to an accumulator.
static inline void add_term(double term, int64_t &sum) noexcept {
    // unsigned, since padding beyond the grid may overflow
    sum = static_cast<int64_t>(static_cast<uint64_t>(sum) + quantised(term));
}

// Adds a row of terms to a row of accumulators.
static inline void add_terms(const double *__restrict terms, int64_t *__restrict out) noexcept {
    for (size_t j = 0; j < kBlock; j++)
        add_term(terms[j], out[j]);
}

} // namespace toliman::kernels
