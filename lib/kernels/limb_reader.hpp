// Converts the integer accumulators of kernels/push.hpp to double with one rounding, by shifts and by writing into the
// mantissa of a double, which vectorises on every instruction set.
//
// All code is in the namespace of the instruction set, so that each file keeps its own copy (kernels/isa.hpp).
#pragma once
#include <cstdint>

namespace toliman::kernels::TOLIMAN_ISA {
namespace {

// Whether the instruction set has vector shifts and conversions of signed 64-bit integers.
#if defined(__AVX512DQ__)
constexpr bool kSigned = true;
#else
constexpr bool kSigned = false;
#endif

// Bits of the doubles 2^52 and 2^84: or-ing an integer into their mantissa adds it, in units of 1 and 2^32.
constexpr uint64_t kBits52 = 0x4330000000000000u, kBits84 = 0x4530000000000000u;
constexpr uint64_t kSign = 0x8000000000000000u, kLowerHalf = 0xffffffffu;

inline double with_bits(uint64_t bits) noexcept {
    double value;
    __builtin_memcpy(&value, &bits, sizeof value);
    return value;
}

inline double power_of_two(int n) noexcept {
    return with_bits(static_cast<uint64_t>(1023 + n) << 52);
}

struct Halves {
    double upper, lower; // an unevaluated sum; of an integer x: floor(x/2^32) 2^32 and x modulo 2^32
};

// a - b and its rounding error (Knuth's two-sum).
inline Halves difference(double a, double b) noexcept {
    const double upper = a - b, back = upper - a;
    return {upper, (a - (upper - back)) - (b + back)};
}

// Converts sums to double: x = (hi 2^32 + lo)/2^shift, rounded to the nearest integer, halves up. The result does not
// depend on how the sum is divided between hi and lo.
class Reader {
  public:
    // Chooses shift so that sums up to `largest` 2^50 become integers up to 2^bits.
    Reader(double largest, int bits) noexcept {
        const int above = largest < 1 ? 0 : 63 - __builtin_clzll(static_cast<uint64_t>(largest)) - (bits - 51);
        if (above <= 0)
            return;
        shift_ = above;
        offset_ = kSigned ? 0 : kSign >> above;
        bias_ = (kSigned ? 0 : kSign) + (uint64_t{1} << (above - 1));
        excess_ += static_cast<double>(offset_);
    }
    int shift() const noexcept { return shift_; }

    double small(int64_t lo, int64_t hi) const noexcept { // x, |x| up to 2^51: exact
        constexpr uint64_t kMiddle = uint64_t{1} << 51;
        const uint64_t x = integer(lo, hi);
        return kSigned ? static_cast<double>(static_cast<int64_t>(x))
                       : with_bits(x + (kBits52 + kMiddle - offset_)) - (0x1p52 + 0x1p51);
    }
    double large(int64_t lo, int64_t hi) const noexcept { // x, |x| up to 2^62, rounded to double
        const uint64_t x = integer(lo, hi);
        return kSigned ? static_cast<double>(static_cast<int64_t>(x)) : (upper(x) - (excess_ + 0x1p52)) + lower(x);
    }
    Halves halves(int64_t lo, int64_t hi) const noexcept { // x, |x| up to 2^62: exact
        const uint64_t x = integer(lo, hi);
        return {upper(x) - excess_, lower(x) - 0x1p52};
    }

  private:
    uint64_t integer(int64_t lo, int64_t hi) const noexcept { // x + offset
        const uint64_t rounded = static_cast<uint64_t>(lo) + bias_;
        const uint64_t low =
            kSigned ? static_cast<uint64_t>(static_cast<int64_t>(rounded) >> shift_) : rounded >> shift_;
        return (static_cast<uint64_t>(hi) << (32 - shift_)) + low;
    }
    static double upper(uint64_t x) noexcept { return with_bits((x >> 32) ^ (kBits84 + 0x80000000u)); }
    static double lower(uint64_t x) noexcept { return with_bits((x & kLowerHalf) | kBits52); }

    int shift_ = 0;
    uint64_t bias_ = 0, offset_ = 0;
    double excess_ =
        0x1p84 + 0x1p63; // upper() minus the upper half; a multiple of 2^32, so that its subtraction is exact
};

} // namespace
} // namespace toliman::kernels::TOLIMAN_ISA
