#include "kernels/elu.hpp"

#include <cstdint>

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// exp(x) - 1 = 2^n (exp(f) - 1) + (2^n - 1) with |f| <= ln(2)/2: for n = 0 the first term stands alone, otherwise the
// two have one sign or differ enough, so nothing cancels.
inline float expm1_negative(float x) noexcept {
    constexpr float kRound = 0x1.8p23f; // adding it rounds to an integer, left in the low bits
    const float shifted = x * 1.44269504f + kRound;
    const float n = shifted - kRound;
    const float f = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float q = 1.9875691500e-4f;
    q = q * f + 1.3981999507e-3f;
    q = q * f + 8.3334519073e-3f;
    q = q * f + 4.1665795894e-2f;
    q = q * f + 1.6666665459e-1f;
    q = q * f + 5.0000001201e-1f;
    uint32_t bits;
    __builtin_memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 23) + 0x3f800000u;
    float power;
    __builtin_memcpy(&power, &bits, sizeof power);
    return power * (f + f * f * q) + (power - 1.0f);
}

void elu(float *values, size_t count) noexcept {
    for (size_t i = 0; i < count; i++) {
        const float x = values[i];
        const float below = expm1_negative(x < 0 ? (x > -30.0f ? x : -30.0f) : 0.0f);
        values[i] = x <= 0 ? below : x;
    }
}

} // namespace
} // namespace TOLIMAN_ISA

const EluKernels TOLIMAN_ISA_TABLE(elu) = {TOLIMAN_ISA::elu};

} // namespace toliman::kernels
