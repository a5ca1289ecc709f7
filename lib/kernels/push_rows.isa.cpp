// Method: as kernels/push.isa.cpp with double-limb sums, for y and K - 1 nuisance functions b of a sample: w b cos and
// w b sin are further terms of the form w y cos. Cosine and sine are computed once per frequency for all of them.
//
// Cosine and sine are double-double numbers. The fit sees only what remains of the cosine after projecting the
// functions out of it, 1e-7 of it for 8 polynomials and 0.3 cycles. Cosines to 4e-16, which suffice for the mean alone,
// left an error of the power of 1e-9 there.
//
// The cosine and sine of frequency 64 (64 i + b) + j is the product of three points on the unit circle: the start of
// each 4096 frequencies, computed from its phase, and two tables of 64, for the steps 64 df and df. A table grows by
// doubling, so that few points are computed from a phase. Error: 64 roundings of 2^-104 in the tables.
#include "kernels/push_rows.hpp"

#include "kernels/cis_pair.hpp"
#include "kernels/limbs.hpp"

namespace toliman::kernels::TOLIMAN_ISA {
namespace {

// Points on the unit circle.
struct alignas(64) Circle {
    double c[kBlock], c_error[kBlock], s[kBlock], s_error[kBlock];
};

inline CisPair point(const Circle &circle, size_t j) noexcept {
    return {{circle.c[j], circle.c_error[j]}, {circle.s[j], circle.s_error[j]}};
}

// Turns the first n points by a phase.
inline void turn(const Circle &circle, CisPair by, size_t n, size_t first, Circle &out) noexcept {
    for (size_t j = 0; j < n; j++) {
        const CisPair to = turned(point(circle, j), by);
        out.c[first + j] = to.cosine.value;
        out.c_error[first + j] = to.cosine.error;
        out.s[first + j] = to.sine.value;
        out.s_error[first + j] = to.sine.error;
    }
}

// The points of kBlock multiples of the frequency f.
void set_table(double f, Pair t, Circle &table) noexcept {
    table.c[0] = 1;
    table.c_error[0] = table.s[0] = table.s_error[0] = 0;
    CisPair step = cis_pair(reduced_product({f, 0}, t));
    for (size_t n = 1; n < kBlock; n *= 2) {
        turn(table, step, n, n, table);
        step = turned(step, step);
    }
}

// f0 + df k.
Pair frequency(double f0, double df, size_t k) noexcept {
    const Pair step = product(df, static_cast<double>(k));
    const Pair high = difference(step.value, -f0);
    return normalised({high.value, high.error + step.error});
}

// Adds a term, in units of 2^-50, to its two limbs.
inline void add_two(Pair term, int64_t &high, int64_t &low) noexcept {
    double first, second;
    split_limbs(term, first, second);
    add_term(first, high);
    add_term(second, low);
}

// Adds w cos, w sin, w cos 2x and w sin 2x.
void add_weights(double weight, const Circle &circle, int64_t *__restrict c, int64_t *__restrict s,
                 int64_t *__restrict c2, int64_t *__restrict s2, int64_t *__restrict c_low, int64_t *__restrict s_low,
                 int64_t *__restrict c2_low, int64_t *__restrict s2_low) noexcept {
    const double w = weight * kOne;
    for (size_t j = 0; j < kBlock; j++) {
        const Pair cosine = {circle.c[j], circle.c_error[j]}, sine = {circle.s[j], circle.s_error[j]};
        add_two(scaled(w, cosine), c[j], c_low[j]);
        add_two(scaled(w, sine), s[j], s_low[j]);
        add_two(scaled(w, difference(product(cosine, cosine), product(sine, sine))), c2[j], c2_low[j]);
        add_two(scaled(2 * w, product(sine, cosine)), s2[j], s2_low[j]);
    }
}

// v cos and v sin of a value v.
inline Pair times(Pair value, double x, double x_error) noexcept {
    const Pair p = scaled(value.value, {x, x_error});
    return {p.value, p.error + value.error * x};
}

// Adds the terms w b cos and w b sin of a function, with w b = `value` in units of 2^-50, to their two limbs.
void add_function(Pair value, const Circle &circle, int64_t *__restrict c, int64_t *__restrict s,
                  int64_t *__restrict c_low, int64_t *__restrict s_low) noexcept {
    for (size_t j = 0; j < kBlock; j++) {
        add_two(times(value, circle.c[j], circle.c_error[j]), c[j], c_low[j]);
        add_two(times(value, circle.s[j], circle.s_error[j]), s[j], s_low[j]);
    }
}

// Adds the terms w y cos and w y sin to their three limbs.
void add_value(Pair value, const Circle &circle, int64_t *__restrict c, int64_t *__restrict s,
               int64_t *__restrict c_low, int64_t *__restrict s_low, int64_t *__restrict c_lowest,
               int64_t *__restrict s_lowest) noexcept {
    for (size_t j = 0; j < kBlock; j++) {
        double high, low;
        add_term(split_limbs(times(value, circle.c[j], circle.c_error[j]), high, low), c_lowest[j]);
        add_term(high, c[j]);
        add_term(low, c_low[j]);
        add_term(split_limbs(times(value, circle.s[j], circle.s_error[j]), high, low), s_lowest[j]);
        add_term(high, s[j]);
        add_term(low, s_low[j]);
    }
}

// w y and w b_1 ... in units of 2^-50.
inline Pair value_of(const PushRow &row, size_t i) noexcept {
    return scaled(row.weight, {row.value_high[i] * kOne, row.value_low[i] * kOne});
}

void push_rows(double f0, double df, size_t blocks, const PushRow &row, int64_t *const *lo) noexcept {
    Circle coarse, fine, circle;
    const Pair t = {row.t_high, row.t_low};
    set_table(df * kBlock, t, coarse);
    set_table(df, t, fine);
    CisPair start = {};
    for (size_t b = 0; b < blocks; b++) {
        if (b % kBlock == 0)
            start = cis_pair(reduced_product(frequency(f0, df, b * kBlock), t));
        const size_t at = b * kBlock;
        turn(fine, turned(start, point(coarse, b % kBlock)), kBlock, 0, circle);
        add_weights(row.weight, circle, lo[kC1] + at, lo[kS1] + at, lo[kC2] + at, lo[kS2] + at, lo[kC1Low] + at,
                    lo[kS1Low] + at, lo[kC2Low] + at, lo[kS2Low] + at);
        add_value(value_of(row, 0), circle, lo[kYC] + at, lo[kYS] + at, lo[kYCLow] + at, lo[kYSLow] + at,
                  lo[kYCLowest] + at, lo[kYSLowest] + at);
        for (size_t i = 1; i < row.functions; i++) {
            int64_t *const *const sums = lo + kSums + (i - 1) * kFunctionSums;
            add_function(value_of(row, i), circle, sums[kFunctionC] + at, sums[kFunctionS] + at,
                         sums[kFunctionCLow] + at, sums[kFunctionSLow] + at);
        }
    }
}

} // namespace
} // namespace toliman::kernels::TOLIMAN_ISA

namespace toliman::kernels {
extern const PushRowsKernels TOLIMAN_ISA_TABLE(push_rows) = {TOLIMAN_ISA::push_rows};
}
