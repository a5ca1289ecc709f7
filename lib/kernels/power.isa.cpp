#include "kernels/power.hpp"

#include "kernels/push.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr double kBase = 0x1p32;

#if defined(__AVX512DQ__)
// The upper part of hi 2^32 + lo, whose lower 32 bits are those of lo.
inline uint64_t upper_part(int64_t lo, int64_t hi) noexcept {
    return static_cast<uint64_t>(hi + (lo >> 32));
}
// Halves of x as doubles, the upper one with its sign.
inline double lower_half(uint64_t x) noexcept {
    return static_cast<double>(static_cast<int64_t>(x & 0xffffffffu));
}
inline double upper_half(uint64_t x) noexcept {
    return static_cast<double>(static_cast<int64_t>(x) >> 32);
}
// An upper part as a double, exact.
inline double whole(uint64_t x) noexcept {
    return static_cast<double>(static_cast<int64_t>(x));
}
#else
// The same by their bits: conversions and signed shifts of 64-bit integers do not vectorise below AVX-512.
inline uint64_t upper_part(int64_t lo, int64_t hi) noexcept {
    const uint64_t carry = ((static_cast<uint64_t>(lo) ^ 0x8000000000000000u) >> 32) - 0x80000000u;
    return static_cast<uint64_t>(hi) + carry;
}
inline double with_exponent(uint64_t x) noexcept {
    x |= 0x4330000000000000u;
    double value;
    __builtin_memcpy(&value, &x, sizeof value);
    return value; // 2^52 + x
}
inline double lower_half(uint64_t x) noexcept {
    return with_exponent(x & 0xffffffffu) - 0x1p52;
}
inline double upper_half(uint64_t x) noexcept {
    return with_exponent((x ^ 0x8000000000000000u) >> 32) - (0x1p52 + 0x1p31);
}
inline double whole(uint64_t x) noexcept {
    return upper_half(x) * kBase + lower_half(x);
}
#endif

// hi 2^32 + lo, rounded to double.
inline double plain(int64_t lo, int64_t hi) noexcept {
    return whole(upper_part(lo, hi)) * kBase + lower_half(static_cast<uint64_t>(lo));
}

struct Pair {
    double high, low; // an unevaluated sum
};

// hi 2^32 + lo, off by 2^-105 of it at most.
inline Pair pair(int64_t lo, int64_t hi) noexcept {
    const uint64_t upper = upper_part(lo, hi);
    const double a = upper_half(upper) * (kBase * kBase), b = lower_half(upper) * kBase; // a is 0 or the larger
    const double most = a + b, rest = (b - (most - a)) + lower_half(static_cast<uint64_t>(lo));
    const double high = most + rest;
    return {high, rest - (high - most)};
}

// a b and its rounding error (Dekker, Veltkamp): exact without fused multiply-add.
inline Pair product(double a, double b) noexcept {
    constexpr double kSplit = 0x1p27 + 1;
    const double ac = kSplit * a, bc = kSplit * b, ah = ac - (ac - a), bh = bc - (bc - b), al = a - ah, bl = b - bh;
    const double high = a * b;
    return {high, ((ah * bh - high) + ah * bl + al * bh) + al * bl};
}

// a + b and its rounding error (Knuth).
inline Pair sum(double a, double b) noexcept {
    const double high = a + b, back = high - a;
    return {high, (a - (high - back)) + (b - back)};
}

// y - mean x, in units of 2^-50; rest: what y has below, in units of 2^-100.
inline double centred(const Pair &y, const Pair &rest, const Pair &x, const PowerShared &shared) noexcept {
    constexpr double kUnit = 0x1p-50;
    const Pair most = product(shared.mean_high, x.high);
    const double low = shared.mean_high * x.low + shared.mean_low * x.high;
    const Pair gap = sum(y.high, -most.high), all = sum(gap.high, rest.high * kUnit);
    return all.high + (all.low + (gap.low + ((y.low - most.low) - low + rest.low * kUnit)));
}

// large_mean: many standard deviations from 0.
template <bool large_mean>
void power_of(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
              double *out) noexcept {
    constexpr double kUnit = 0x1p-50;
    const double part = shared.part * kUnit, moving = shared.fixed_mean ? 0.0 : 1.0, mean = shared.mean_high;
    const double per_spread = 1 / shared.spread;
    for (size_t k = 0; k < n; k++) {
        const auto number = [&](int i) { return plain(lo[i][k], hi[i][k]); };
        const double c1 = number(kC1), s1 = number(kS1), c = part * c1, s = part * s1;
        double yc, ys;
        if (large_mean) {
            const auto exact = [&](int i) { return pair(lo[i][k], hi[i][k]); };
            yc = part * centred(exact(kYC), exact(kYCLow), exact(kC1), shared);
            ys = part * centred(exact(kYS), exact(kYSLow), exact(kS1), shared);
        } else {
            yc = part * ((number(kYC) - mean * c1) + number(kYCLow) * kUnit);
            ys = part * ((number(kYS) - mean * s1) + number(kYSLow) * kUnit);
        }
        const double half_c2 = 0.5 * part * number(kC2), half_s2 = 0.5 * part * number(kS2);
        const double cc = (0.5 + half_c2) - moving * c * c, ss = (0.5 - half_c2) - moving * s * s;
        const double cs = half_s2 - moving * c * s, determinant = cc * ss - cs * cs;
        const double explained = (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / determinant * per_spread;
        const double most = explained < 1 ? explained : 1.0;
        out[k] = determinant < kLeastDeterminant ? kNeedsMore : most > 0 ? most : 0.0;
    }
}

void power(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
           double *out) noexcept {
    constexpr double kLarge = 64;
    const bool large = shared.mean_high * shared.mean_high > kLarge * kLarge * shared.spread;
    (large ? power_of<true> : power_of<false>)(lo, hi, n, shared, out);
}

} // namespace
} // namespace TOLIMAN_ISA

const PowerKernels TOLIMAN_ISA_TABLE(power) = {TOLIMAN_ISA::power};

} // namespace toliman::kernels
