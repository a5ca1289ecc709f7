// ELU of contiguous floats, for files compiled once per instruction set; everything is in that set's namespace.
//
// Method: ELU(x) = x for x > 0, exp(x) - 1 otherwise, with expm1 by argument reduction x = n ln 2 + f, |f| <= ln(2)/2:
//     exp(x) - 1 = 2^n (exp(f) - 1) + (2^n - 1),    exp(f) - 1 = f + f^2 p(f), p of degree 5 (Cephes expf)
// The direct form exp(x) - 1 loses the digits of small x, and activations are small by design: tied training scales the
// input by 1e-3, where ELU is nearly linear. Two terms of p are therefore enough below 0.005, and blocks of 256 values
// without one below -0.005 compute no more; those without one below -ln(2)/2 skip the reduction. A value's bits do not
// depend on its block.
#pragma once
#include <cstddef>
#include <cstdint>

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// NOLINTBEGIN(misc-definitions-in-headers): each file that includes this has it in a namespace of its own
constexpr float kHalfLog2 = 0.34657359f, kTiny = 0.005f;
constexpr size_t kBlock = 256;

// a b + c, with one rounding where the instruction set has that: left to the compiler, bits could depend on the block.
inline float fused(float a, float b, float c) noexcept {
#if defined(__FMA__) || defined(__aarch64__)
    return __builtin_fmaf(a, b, c);
#else
    return a * b + c;
#endif
}

// (exp(f) - 1 - f)/f^2 for |f| < kTiny: the rest of the series is below 5e-9 of f.
inline float tiny_tail(float f) noexcept {
    return fused(f, 1.6666665459e-1f, 5.0000001201e-1f);
}

// The same for |f| <= ln(2)/2.
inline float expm1_tail(float f) noexcept {
    float q = 1.9875691500e-4f;
    q = fused(q, f, 1.3981999507e-3f);
    q = fused(q, f, 8.3334519073e-3f);
    q = fused(q, f, 4.1665795894e-2f);
    q = fused(q, f, 1.6666665459e-1f);
    q = fused(q, f, 5.0000001201e-1f);
    return f > -kTiny && f < kTiny ? tiny_tail(f) : q;
}

// exp(x) - 1 for x <= 0. For n = 0 the second term vanishes; otherwise the two terms have the same sign or differ
// enough in magnitude, so that they do not cancel.
inline float expm1_negative(float x) noexcept {
    constexpr float kRound = 0x1.8p23f; // adding it rounds to an integer in the low mantissa bits
    const float shifted = fused(x, 1.44269504f, kRound);
    const float n = shifted - kRound;
    const float f = fused(n, 2.12194440e-4f, fused(-n, 0.693359375f, x));
    uint32_t bits;
    __builtin_memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 23) + 0x3f800000u;
    float power;
    __builtin_memcpy(&power, &bits, sizeof power);
    return fused(power, fused(f * f, expm1_tail(f), f), power - 1.0f);
}

// For values above -ln(2)/2, which need no reduction; the same bits as expm1_negative, where n = 0.
inline void elu_small(float *values, size_t count) noexcept {
    for (size_t i = 0; i < count; i++) {
        const float x = values[i];
        const float below = fused(x * x, expm1_tail(x), x);
        values[i] = x <= 0 ? below : x;
    }
}

inline void elu_any(float *values, size_t count) noexcept {
    for (size_t i = 0; i < count; i++) {
        const float x = values[i];
        const float below = expm1_negative(x < 0 ? (x > -30.0f ? x : -30.0f) : 0.0f);
        values[i] = x <= 0 ? below : x;
    }
}

// For values above -kTiny; the same bits as elu_small.
inline void elu_tiny(float *values, size_t count) noexcept {
    for (size_t i = 0; i < count; i++) {
        const float x = values[i];
        const float below = fused(x * x, tiny_tail(x), x);
        values[i] = x <= 0 ? below : x;
    }
}

inline bool any_below(float limit, const float *values, size_t count) noexcept {
    uint32_t below = 0;
    for (size_t i = 0; i < count; i++)
        below |= values[i] < limit ? 1u : 0u;
    return below != 0;
}

// At most one block. Inlined with a constant size, the loops need no remainder.
inline __attribute__((always_inline)) void elu_block(float *values, size_t size) noexcept {
    if (!any_below(-kTiny, values, size))
        elu_tiny(values, size);
    else if (!any_below(-kHalfLog2 + 1e-6f, values, size))
        elu_small(values, size);
    else
        elu_any(values, size);
}

void elu(float *values, size_t count) noexcept {
    size_t i = 0;
    for (; i + kBlock <= count; i += kBlock)
        elu_block(values + i, kBlock);
    elu_block(values + i, count - i);
}

} // namespace
} // namespace TOLIMAN_ISA
} // namespace toliman::kernels
// NOLINTEND(misc-definitions-in-headers)
