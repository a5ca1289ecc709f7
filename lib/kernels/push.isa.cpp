// Method: for a sample (t, y) of weight w and every f_k = f0 + k df, adds to integer accumulators
//     w cos 2 pi p, w sin 2 pi p, w cos 4 pi p, w sin 4 pi p, w y cos 2 pi p, w y sin 2 pi p
// with the phase p = f_k t in cycles. Frequencies are grouped in blocks of 64. The phase of a block's first frequency
// (its anchor) is reduced modulo 1 exactly; the 64 angles within a block are common to all blocks. A frequency then
// costs one complex product, cos(a + b) = cos a cos b - sin a sin b, and no sine.
//
// Each term is rounded to an integer (units of 2^-50, its remainder to the next limb) before it is added. Integer
// addition is exact and associative: the sums do not depend on the order of samples, on threads or on shards, and a
// sample can be removed exactly. Floating-point sums, compensated ones included, have none of these properties. Plain
// double was hardly faster in a prototype: 0.9 ns per frequency and push against 1.0 ns (AVX-512) or 1.5 ns (AVX2). A
// double-limb push takes three times as long as a single-limb push, and is therefore optional.
//
// Products are made exact by FMA or by Dekker's splitting, with equal results: the same bits on every instruction set.
// Error: c and s within 4e-16 (kernels/push.hpp). Tested against 113-bit arithmetic in tests/kernel/test_push.c.
//
// Reference: kernels/pair.hpp, exact products and differences.
#include "kernels/push.hpp"

#include "kernels/limbs.hpp"

namespace toliman::kernels::TOLIMAN_ISA {
namespace {

void set_anchors(double f0, double df, size_t blocks, const PushSample &sample, double *cosines,
                 double *sines) noexcept {
    for (size_t b = 0; b < blocks; b++) { // f0 + df k as an unevaluated sum
        const double k = static_cast<double>(b * kBlock), step = df * k, step_error = product_error(df, k, step);
        const double high = f0 + step, back = high - f0;
        const double low = (f0 - (high - back)) + (step - back) + step_error;
        cis_product(high, low, sample.t_high, sample.t_low, cosines[b], sines[b]);
    }
}

// The block's eight rows of terms. A separate pass, because compilers do not vectorise one loop that also updates eight
// accumulators.
inline void single_limb_terms(double c0, double s0, const double *table_c, const double *table_s,
                              const PushSample &sample, double (*terms)[kBlock]) noexcept {
    const double w = sample.weight * kOne, y = sample.weight * (sample.value_high * kOne);
    const double y_low =
        (sample.weight * sample.value_low * kOne + product_error(sample.weight, sample.value_high * kOne, y)) * kOne;
    for (size_t j = 0; j < kBlock; j++) {
        const double c = table_c[j] * c0 - table_s[j] * s0, s = table_s[j] * c0 + table_c[j] * s0;
        const double yc = y * c, ys = y * s;
        terms[kC1][j] = w * c;
        terms[kS1][j] = w * s;
        terms[kC2][j] = w * (c * c - s * s);
        terms[kS2][j] = (2 * w) * (s * c);
        terms[kYC][j] = yc;
        terms[kYS][j] = ys;
        terms[kYCLow][j] = ((yc - nearest_whole(yc)) + product_error(y, c, yc)) * kOne + y_low * c;
        terms[kYSLow][j] = ((ys - nearest_whole(ys)) + product_error(y, s, ys)) * kOne + y_low * s;
    }
}

inline void double_limb_terms(double c0, double s0, const double *table_c, const double *table_s,
                              const PushSample &sample, double (*terms)[kBlock]) noexcept {
    const double w = sample.weight * kOne;
    const Pair y = scaled(sample.weight, {sample.value_high * kOne, sample.value_low * kOne});
    for (size_t j = 0; j < kBlock; j++) {
        const double c = table_c[j] * c0 - table_s[j] * s0, s = table_s[j] * c0 + table_c[j] * s0;
        // c + i s is some 1e-16 off the unit circle. With off = 1 - c^2 - s^2, the factor 1 + off/2 corrects that to
        // 1e-31.
        const Pair cc = product(c, c), ss = product(s, s), sc = product(s, c), sine2 = difference(1.0, cc.value);
        const Pair gap = difference(sine2.value, ss.value), cos2 = difference(cc.value, ss.value);
        const double off = gap.value + (gap.error + ((sine2.error - cc.error) - ss.error));
        const Pair unit_c = {c, c * (0.5 * off)}, unit_s = {s, s * (0.5 * off)};
        split_limbs(scaled(w, unit_c), terms[kC1][j], terms[kC1Low][j]);
        split_limbs(scaled(w, unit_s), terms[kS1][j], terms[kS1Low][j]);
        split_limbs(scaled(w, {cos2.value, (cos2.error + (cc.error - ss.error)) + cos2.value * off}), terms[kC2][j],
                    terms[kC2Low][j]);
        split_limbs(scaled(2 * w, {sc.value, sc.error + sc.value * off}), terms[kS2][j], terms[kS2Low][j]);
        const Pair yc = scaled(y.value, unit_c), ys = scaled(y.value, unit_s);
        terms[kYCLowest][j] = split_limbs({yc.value, yc.error + y.error * c}, terms[kYC][j], terms[kYCLow][j]);
        terms[kYSLowest][j] = split_limbs({ys.value, ys.error + y.error * s}, terms[kYS][j], terms[kYSLow][j]);
    }
}

using Terms = void(double c0, double s0, const double *table_c, const double *table_s, const PushSample &sample,
                   double (*terms)[kBlock]) noexcept;

template <int sums, Terms make_terms>
void push(double f0, double df, size_t blocks, const PushSample &sample, double *anchors, int64_t *const *lo) noexcept {
    alignas(64) double table_c[kBlock], table_s[kBlock], terms[sums][kBlock];
    for (size_t j = 0; j < kBlock; j++) {
        const double k = static_cast<double>(j), step = df * k;
        cis_product(step, product_error(df, k, step), sample.t_high, sample.t_low, table_c[j], table_s[j]);
    }
    double *const anchor_c = anchors, *const anchor_s = anchors + blocks;
    set_anchors(f0, df, blocks, sample, anchor_c, anchor_s);
    for (size_t b = 0; b < blocks; b++) {
        make_terms(anchor_c[b], anchor_s[b], table_c, table_s, sample, terms);
        for (int sum = 0; sum < sums; sum++)
            add_terms(terms[sum], lo[sum] + b * kBlock);
    }
}

void fold(int64_t *lo, int64_t *hi, size_t n) noexcept {
    for (size_t k = 0; k < n; k++) {
        hi[k] += lo[k] >> 32;
        lo[k] &= kFoldBase - 1;
    }
}

void cis(double f_high, double f_low, double t_high, double t_low, double *cosine, double *sine) noexcept {
    cis_product(f_high, f_low, t_high, t_low, *cosine, *sine);
}

} // namespace
} // namespace toliman::kernels::TOLIMAN_ISA

namespace toliman::kernels {
extern const PushKernels TOLIMAN_ISA_TABLE(push) = {TOLIMAN_ISA::push<kSingleLimbSums, TOLIMAN_ISA::single_limb_terms>,
                                                    TOLIMAN_ISA::push<kSums, TOLIMAN_ISA::double_limb_terms>,
                                                    TOLIMAN_ISA::fold, TOLIMAN_ISA::cis};
}
