// Double-double numbers, about 106 bits: unevaluated sums of two doubles. Only +, -, * and exact products, without
// branches: loops vectorise, and every machine computes the same bits.
//
// All functions are static, so that each file keeps the copy of its own instruction set (kernels/isa.hpp).
//
// Reference: Dekker (1971), Numer. Math. 18, 224, exact products; Knuth, The Art of Computer Programming, vol. 2, sec.
// 4.2.2, exact differences.
#pragma once

#include "kernels/cis.hpp"

namespace toliman::kernels {

// value + error, |error| below an ulp of value.
struct Pair {
    double value, error;
};

static inline Pair product(double a, double b) noexcept {
    const double p = a * b;
    return {p, product_error(a, b, p)};
}

static inline Pair difference(double a, double b) noexcept {
    const double d = a - b, back = d - a;
    return {d, (a - (d - back)) - (b + back)};
}

// factor x, with a relative error of 2^-104.
static inline Pair scaled(double factor, Pair x) noexcept {
    const Pair p = product(factor, x.value);
    return {p.value, p.error + factor * x.error};
}

// Moves what an error exceeds an ulp by into the value; |value| must not be below |error|.
static inline Pair normalised(Pair x) noexcept {
    const double value = x.value + x.error;
    return {value, x.error - (value - x.value)};
}

// a - b and a b, with an error of 2^-104 of the larger operand and of the product.
static inline Pair difference(Pair a, Pair b) noexcept {
    const Pair d = difference(a.value, b.value);
    return normalised({d.value, d.error + (a.error - b.error)});
}

static inline Pair product(Pair a, Pair b) noexcept {
    const Pair p = product(a.value, b.value);
    return normalised({p.value, p.error + (a.value * b.error + a.error * b.value)});
}

static inline Pair sum(Pair a, Pair b) noexcept {
    return difference(a, {-b.value, -b.error});
}

static inline Pair quotient(Pair a, double divisor) noexcept {
    const double q = a.value / divisor;
    return normalised({q, (a.error - product_error(q, divisor, a.value)) / divisor});
}

} // namespace toliman::kernels
