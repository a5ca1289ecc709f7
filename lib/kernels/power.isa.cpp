#include "kernels/power.hpp"

#include "kernels/push.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Whether vectors can shift and convert signed integers of 64 bits.
#if defined(__AVX512DQ__)
constexpr bool kSigned = true;
#else
constexpr bool kSigned = false;
#endif

// Bits of 2^52 and 2^84, below which an integer can stand as the lower bits of a double.
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
    double upper, lower; // an exact sum; of an integer x, floor(x/2^32) 2^32 and the rest
};

// a - b and its rounding error (Knuth).
inline Halves difference(double a, double b) noexcept {
    const double upper = a - b, back = upper - a;
    return {upper, (a - (upper - back)) - (b + back)};
}

// Reads a sum as x = (hi 2^32 + lo)/2^shift to the nearest integer, halves up: the same however the sum is split.
class Reading {
  public:
    // Sums up to `most` 2^50 become integers up to 2^bits.
    Reading(double most, int bits) noexcept {
        const int above = most < 1 ? 0 : 63 - __builtin_clzll(static_cast<uint64_t>(most)) - (bits - 51);
        if (above <= 0)
            return;
        shift_ = above;
        offset_ = kSigned ? 0 : kSign >> above;
        bias_ = (kSigned ? 0 : kSign) + (uint64_t{1} << (above - 1));
        excess_ += static_cast<double>(offset_);
    }
    int shift() const noexcept { return shift_; }

    double brief(int64_t lo, int64_t hi) const noexcept { // |x| up to 2^51
        constexpr uint64_t kMiddle = uint64_t{1} << 51;
        const uint64_t x = integer(lo, hi);
        return kSigned ? static_cast<double>(static_cast<int64_t>(x))
                       : with_bits(x + (kBits52 + kMiddle - offset_)) - (0x1p52 + 0x1p51);
    }
    double full(int64_t lo, int64_t hi) const noexcept { // |x| up to 2^62
        const uint64_t x = integer(lo, hi);
        return kSigned ? static_cast<double>(static_cast<int64_t>(x)) : (upper(x) - (excess_ + 0x1p52)) + lower(x);
    }
    Halves halves(int64_t lo, int64_t hi) const noexcept { // |x| up to 2^62
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
    double excess_ = 0x1p84 + 0x1p63; // of upper() over the upper half; a multiple of 2^32 as it, so that all is exact
};

// far_mean: many standard deviations from 0. Then y - mean x is formed from halves of y and x: times the first 20 bits
// of the mean they are exact, and the roundings left are those of numbers as small as the result.
// wide: cosines have lower limbs.
template <bool far_mean, bool fixed_mean, bool wide>
size_t power_of(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
                double *out) noexcept {
    // No sum of w y c is above W times the root mean square of y.
    const double largest = shared.weight * __builtin_sqrt(shared.mean_high * shared.mean_high + shared.spread);
    const Reading value(largest, 62), rest(static_cast<double>(shared.samples), 51), narrow(shared.weight, 51);
    const Reading cosine(shared.weight, far_mean ? 62 : 51);
    // Units are 2^-50 by the shifts: of c and s 2^cosine, of c2 and s2 2^narrow, of products of two and W^2 4^cosine;
    // of y, yc and ys 2^value, of the limb below 2^rest 2^-50.
    const double weight = shared.weight * power_of_two(50 - cosine.shift()), square = 0.5 * weight * weight;
    const double half = 0.5 * weight * power_of_two(narrow.shift() - cosine.shift());
    const double least = kLeastDeterminant * (weight * weight) * (weight * weight);
    const double below = power_of_two(rest.shift() - value.shift() - 50);
    const double below_cosine = power_of_two(rest.shift() - cosine.shift() - 50);
    const double below_second = power_of_two(rest.shift() - narrow.shift() - 50);
    const double unit = power_of_two(value.shift() - cosine.shift()), per_spread = unit * unit / (2 * shared.spread);
    const double mean = shared.mean_high / unit, split = (0x1p33 + 1) * mean;
    const double mean_first = split - (split - mean), mean_rest = (mean - mean_first) + shared.mean_low / unit;
    size_t left = 0;
    for (size_t k = 0; k < n; k++) {
        const auto limb = [&](int sum) { return rest.brief(lo[sum][k], hi[sum][k]); };
        double c_rest = 0, s_rest = 0, c, s, yc, ys;
        if (wide) {
            c_rest = limb(kC1Low) * below_cosine;
            s_rest = limb(kS1Low) * below_cosine;
        }
        if (far_mean) {
            const auto centred = [&](int sum, int by, double by_rest, double &x) {
                const Halves y = value.halves(lo[sum][k], hi[sum][k]), part = cosine.halves(lo[by][k], hi[by][k]);
                x = part.upper + part.lower + by_rest;
                const Halves large = difference(y.upper, mean_first * part.upper);
                return (((large.upper + y.lower) - mean_first * part.lower) - (mean_rest * x + mean_first * by_rest)) +
                       large.lower;
            };
            yc = centred(kYC, kC1, c_rest, c);
            ys = centred(kYS, kS1, s_rest, s);
        } else {
            c = cosine.brief(lo[kC1][k], hi[kC1][k]);
            s = cosine.brief(lo[kS1][k], hi[kS1][k]);
            if (wide) {
                c += c_rest;
                s += s_rest;
            }
            yc = value.full(lo[kYC][k], hi[kYC][k]) - mean * c;
            ys = value.full(lo[kYS][k], hi[kYS][k]) - mean * s;
        }
        yc += limb(kYCLow) * below;
        ys += limb(kYSLow) * below;
        double c2 = narrow.brief(lo[kC2][k], hi[kC2][k]), s2 = narrow.brief(lo[kS2][k], hi[kS2][k]);
        if (wide) {
            c2 += limb(kC2Low) * below_second;
            s2 += limb(kS2Low) * below_second;
        }
        c2 *= half;
        s2 *= half;
        const double cc = fixed_mean ? square + c2 : (square + c2) - c * c;
        const double ss = fixed_mean ? square - c2 : (square - c2) - s * s;
        const double cs = fixed_mean ? s2 : s2 - c * s, determinant = cc * ss - cs * cs, cross = yc * cs;
        const double explained = (yc * yc * ss - (cross + cross) * ys + ys * ys * cc) / determinant * per_spread;
        const double power = explained + __builtin_fabs(explained), most = power < 1.0 ? power : 1.0;
        const bool less = determinant < least;
        out[k] = less ? kNeedsMore : most;
        left += less;
    }
    return left;
}

template <bool wide>
size_t power(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerShared &shared,
             double *out) noexcept {
    constexpr double kFar = 8;
    const bool far_mean = shared.mean_high * shared.mean_high > kFar * kFar * shared.spread;
    if (shared.fixed_mean)
        return (far_mean ? power_of<true, true, wide> : power_of<false, true, wide>)(lo, hi, n, shared, out);
    return (far_mean ? power_of<true, false, wide> : power_of<false, false, wide>)(lo, hi, n, shared, out);
}

} // namespace
} // namespace TOLIMAN_ISA

const PowerKernels TOLIMAN_ISA_TABLE(power) = {TOLIMAN_ISA::power<false>, TOLIMAN_ISA::power<true>};

} // namespace toliman::kernels
