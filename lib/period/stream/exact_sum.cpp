// Method: superaccumulator with 32-bit digits in 64-bit places (the small superaccumulator of Neal 2015,
// arXiv:1505.05571). A double touches at most three places; carries are propagated only every 2^30 additions, or on
// reading. The digits are then canonical: equal sums have equal digits in whatever order they were added. Used for the
// few sums without a frequency; products enter by error-free transformations (TwoProd by FMA). Compensated sums would
// depend on the order.
#include "period/stream/exact_sum.hpp"

#include <cmath>
#include <cstring>

namespace toliman {

namespace {
constexpr int kUnitExponent = 1152;        // the unit of place 0 is 2^-1152
constexpr uint32_t kCarryEvery = 1u << 30; // additions below 2^32 that a 64-bit place holds without overflow
constexpr int64_t kDigitMask = 0xffffffff;
} // namespace

void ExactSum::add(double x) noexcept {
    int exponent;
    const double fraction = std::frexp(x, &exponent);                     // |fraction| in [1/2, 1)
    const auto mantissa = static_cast<int64_t>(std::ldexp(fraction, 53)); // exact
    const int shift = exponent - 53 + kUnitExponent;                      // of the mantissa's unit, >= 0
    const size_t place = static_cast<size_t>(shift / 32);
    const auto magnitude = static_cast<unsigned __int128>(mantissa < 0 ? -mantissa : mantissa) << (shift % 32);
    const int64_t sign = mantissa < 0 ? -1 : 1;
    for (size_t i = 0; i < 3; i++)
        places_[place + i] += sign * static_cast<int64_t>((magnitude >> (32 * i)) & kDigitMask);
    if (++pending_ == kCarryEvery)
        carry();
}

void ExactSum::add_product(double a, double b) noexcept {
    const double product = a * b;
    add(product);
    add(std::fma(a, b, -product));
}

void ExactSum::add_product_square(double a, double b) noexcept {
    const double square = b * b;
    add_product(a, square);
    add_product(a, std::fma(b, b, -square));
}

void ExactSum::add(const ExactSum &other) noexcept {
    const Places digits = other.canonical();
    carry();
    for (size_t i = 0; i < kPlaces; i++)
        places_[i] += digits[i];
    carry();
}

void ExactSum::add_quad(Quad x) noexcept {
    for (auto part = static_cast<double>(x); std::fabs(part) > 1e-290; part = static_cast<double>(x)) {
        add(part);
        x -= static_cast<Quad>(part);
    }
}

void ExactSum::carry() noexcept {
    for (size_t i = 0; i + 1 < kPlaces; i++)
        if (const int64_t over = places_[i] >> 32; over != 0) { // rare: most places are 0
            places_[i + 1] += over;
            places_[i] &= kDigitMask;
        }
    pending_ = 0;
}

ExactSum::Places ExactSum::canonical() const noexcept {
    ExactSum copy = *this;
    copy.carry();
    return copy.places_;
}

void ExactSum::assign(const Places &digits) noexcept {
    places_ = digits;
    pending_ = 0;
}

// Replaces the digits by those of the magnitude, whose leading digits do not cancel. Returns whether it was negative.
bool ExactSum::make_positive() noexcept {
    if (places_[kPlaces - 1] >= 0)
        return false;
    for (int64_t &place : places_)
        place = -place;
    carry();
    return true;
}

Quad ExactSum::value() const noexcept {
    ExactSum copy = *this;
    copy.carry();
    const bool negative = copy.make_positive();
    int top = kPlaces - 1;
    while (top > 5 && copy.places_[static_cast<size_t>(top)] == 0)
        top--;
    const auto pair = [&](int below) { // two digits, `below` places under the first
        const auto at = static_cast<size_t>(top - below);
        return static_cast<uint64_t>(copy.places_[at]) << 32 | static_cast<uint64_t>(copy.places_[at - 1]);
    };
    // Six digits have at least 161 bits, even if the first has only one. Few Quad operations, since these are slow.
    __extension__ using Integer = unsigned __int128;
    const Integer first = static_cast<Integer>(pair(0)) << 64 | pair(2);
    const Quad sum = (static_cast<Quad>(first) * static_cast<Quad>(0x1p64) + static_cast<Quad>(pair(4))) *
                     static_cast<Quad>(std::ldexp(1.0L, 32 * (top - 5) - kUnitExponent));
    return negative ? -sum : sum;
}

void ExactSum::add_product(const ExactSum &a, const ExactSum &b, double factor) noexcept {
    double parts_a[kParts], parts_b[kParts];
    const size_t count_a = a.parts(parts_a), count_b = b.parts(parts_b);
    for (size_t i = 0; i < count_a; i++)
        for (size_t j = 0; j < count_b; j++)
            add_product(factor * parts_a[i], parts_b[j]);
}

size_t ExactSum::parts(double *out) const noexcept {
    ExactSum copy = *this;
    copy.carry();
    const double sign = copy.make_positive() ? -1 : 1;
    size_t count = 0;
    for (size_t i = kPlaces; i-- > 0 && count < kParts;)
        if (copy.places_[i] != 0 || count > 0)
            out[count++] =
                sign * std::ldexp(static_cast<double>(copy.places_[i]), 32 * static_cast<int>(i) - kUnitExponent);
    return count;
}

} // namespace toliman
