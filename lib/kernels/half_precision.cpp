// Method: integer arithmetic on the bit patterns. Adding half a unit of the new last place (minus one, plus the last
// bit kept) and shifting rounds to nearest, ties to even; a carry correctly increments the exponent. Subnormal fp16 are
// multiples of 2^-24, by nearbyint. Needs no F16C instructions and gives the same bits on every CPU.
#include "kernels/half_precision.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

constexpr uint16_t kSign = 0x8000, kInfinity = 0x7c00, kFraction = 0x3ff;
constexpr int kDropped = 52 - 10;                         // fraction bits of a double that fp16 lacks
constexpr uint64_t kBias = uint64_t{1023 - 15} << 10;     // difference of the exponent biases of double and fp16
constexpr double kLeastNormal = 0x1p-14, kStep = 0x1p-24; // of fp16

// Removes the lowest `dropped` bits, rounding to nearest even; a carry increments the exponent.
template <class Bits> Bits drop(Bits bits, int dropped) noexcept {
    const Bits half = Bits{1} << (dropped - 1);
    return (bits + half - 1 + ((bits >> dropped) & 1)) >> dropped;
}

} // namespace

float to_float32(double value) noexcept {
    const float nearest = static_cast<float>(value);
    return std::fabs(nearest) < 0x1p-126f ? 0.0f : nearest;
}

uint16_t to_bf16(float value) noexcept {
    uint32_t bits;
    __builtin_memcpy(&bits, &value, sizeof bits);
    return static_cast<uint16_t>(drop(bits, 16));
}

float from_bf16(uint16_t bits) noexcept {
    const uint32_t float_bits = static_cast<uint32_t>(bits) << 16;
    float value;
    __builtin_memcpy(&value, &float_bits, sizeof value);
    return value;
}

uint16_t to_fp16(double value) noexcept {
    const double size = std::fabs(value);
    const uint16_t sign = std::signbit(value) ? kSign : 0;
    if (size < kLeastNormal)
        return sign | static_cast<uint16_t>(std::nearbyint(size / kStep));
    uint64_t bits;
    __builtin_memcpy(&bits, &size, sizeof bits);
    const uint64_t rounded = drop(bits, kDropped) - kBias;
    return sign | (rounded < kInfinity ? static_cast<uint16_t>(rounded) : kInfinity);
}

double from_fp16(uint16_t bits) noexcept {
    const int exponent = (bits >> 10) & 31, fraction = bits & kFraction;
    double size = exponent == 0 ? fraction * kStep : std::ldexp(1024 + fraction, exponent - 25);
    if (exponent == 31)
        size = fraction == 0 ? HUGE_VAL : std::nan("");
    return (bits & kSign) != 0 ? -size : size;
}

} // namespace toliman::kernels
