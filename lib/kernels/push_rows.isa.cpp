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

// Adds w cos, w sin, w cos 2x and w sin 2x.
void add_weights(double weight, const Circle &circle, size_t at, int64_t *const *lo) noexcept {
    alignas(64) double terms[8][kBlock];
    const double w = weight * kOne;
    for (size_t j = 0; j < kBlock; j++) {
        const Pair c = {circle.c[j], circle.c_error[j]}, s = {circle.s[j], circle.s_error[j]};
        const Pair cos2 = difference(product(c, c), product(s, s)), sc = product(s, c);
        split_limbs(scaled(w, c), terms[0][j], terms[4][j]);
        split_limbs(scaled(w, s), terms[1][j], terms[5][j]);
        split_limbs(scaled(w, cos2), terms[2][j], terms[6][j]);
        split_limbs(scaled(2 * w, sc), terms[3][j], terms[7][j]);
    }
    for (size_t i = 0; i < 4; i++) {
        add_terms(terms[i], lo[kC1 + i] + at);
        add_terms(terms[4 + i], lo[kC1Low + i] + at);
    }
}

// Adds the terms w y cos and w y sin with w y = `value`, in units of 2^-50, to their first two limbs and, where the
// pointer is given, to the third.
inline void add_values(Pair value, const Circle &circle, size_t at, int64_t *const *high, int64_t *const *low,
                       int64_t *const *lowest) noexcept {
    alignas(64) double terms[6][kBlock];
    for (size_t j = 0; j < kBlock; j++) {
        const Pair c = scaled(value.value, {circle.c[j], circle.c_error[j]});
        const Pair s = scaled(value.value, {circle.s[j], circle.s_error[j]});
        terms[4][j] = split_limbs({c.value, c.error + value.error * circle.c[j]}, terms[0][j], terms[2][j]);
        terms[5][j] = split_limbs({s.value, s.error + value.error * circle.s[j]}, terms[1][j], terms[3][j]);
    }
    for (size_t i = 0; i < 2; i++) {
        add_terms(terms[i], high[i] + at);
        add_terms(terms[2 + i], low[i] + at);
        if (lowest != nullptr)
            add_terms(terms[4 + i], lowest[i] + at);
    }
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
        add_weights(row.weight, circle, at, lo);
        for (size_t i = 0; i < row.functions; i++) {
            const Pair value = scaled(row.weight, {row.value_high[i] * kOne, row.value_low[i] * kOne});
            int64_t *const *const sums = i == 0 ? lo + kYC : lo + kSums + (i - 1) * kFunctionSums;
            if (i == 0)
                add_values(value, circle, at, sums, lo + kYCLow, lo + kYCLowest);
            else
                add_values(value, circle, at, sums + kFunctionC, sums + kFunctionCLow, nullptr);
        }
    }
}

} // namespace
} // namespace toliman::kernels::TOLIMAN_ISA

namespace toliman::kernels {
extern const PushRowsKernels TOLIMAN_ISA_TABLE(push_rows) = {TOLIMAN_ISA::push_rows};
}
