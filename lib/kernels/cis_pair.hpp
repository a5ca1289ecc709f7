// Cosine and sine of a phase in cycles in double-double, for sums from which functions close to the cosine are
// projected out: a residual of 1e-7 of it keeps 23 digits, where cosines rounded to double would leave 9.
//
// All functions are static, so that each file keeps the copy of its own instruction set (kernels/isa.hpp).
#pragma once

#include "kernels/pair.hpp"

namespace toliman::kernels {

struct CisPair {
    Pair cosine, sine;
};

// The phase f t minus the nearest integer, within 2^-105 |f t| + 2^-105; |f t| < 2^51.
static inline Pair reduced_product(Pair f, Pair t) noexcept {
    const Pair p = product(f.value, t.value);
    const double fraction = reduce_cycles(p.value);
    const Pair high = difference(fraction, -p.error);
    Pair r = sum(high, sum(product(f.value, t.error), product(f.error, t.value)));
    r.error += f.error * t.error;
    const Pair rest = difference(r.value, nearest_whole(r.value));
    return normalised({rest.value, rest.error + r.error});
}

// Given     cycles, |cycles| <= 1/2 up to rounding
// Returned  cosine and sine of 2 pi cycles, within 2^-102: Taylor series up to x^28 of an angle x below pi/4
static inline CisPair cis_pair(Pair cycles) noexcept {
    const double quarter = nearest_whole(4.0 * cycles.value);
    const Pair part = difference(cycles.value, 0.25 * quarter);
    const Pair x = product(normalised({part.value, part.error + cycles.error}), //
                           Pair{6.283185307179586476925, 2.449293598294706414e-16});
    const Pair square = product(x, x), z = {-square.value, -square.error}, one = {1.0, 0.0};
    Pair c = one, s = one;
    for (int m = 28; m > 0; m -= 2) {
        c = sum(one, quotient(product(z, c), m * (m - 1)));
        if (m > 2)
            s = sum(one, quotient(product(z, s), (m - 1) * (m - 2)));
    }
    s = product(x, s);
    const Pair minus_c = {-c.value, -c.error}, minus_s = {-s.value, -s.error};
    if (quarter == 1.0)
        return {minus_s, c};
    if (quarter == -1.0)
        return {s, minus_c};
    return quarter == 0.0 ? CisPair{c, s} : CisPair{minus_c, minus_s};
}

// The product of two numbers on the unit circle: the phases are added.
static inline CisPair turned(CisPair a, CisPair b) noexcept {
    return {difference(product(a.cosine, b.cosine), product(a.sine, b.sine)),
            sum(product(a.sine, b.cosine), product(a.cosine, b.sine))};
}

} // namespace toliman::kernels
