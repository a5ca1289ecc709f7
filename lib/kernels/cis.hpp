// Cosine and sine of a phase in cycles: no branch and no libm, so that loops vectorise and every machine computes the
// same bits. All functions are static: each file, of whatever instruction set, keeps its own copy.
#pragma once

namespace toliman::kernels {

// The whole number nearest to x, ties to even; |x| < 2^51.
static inline double nearest_whole(double x) noexcept {
    return (x + 0x1.8p52) - 0x1.8p52;
}

// x less the nearest whole number, exact; |x| < 2^51.
static inline double reduce_cycles(double x) noexcept {
    return x - nearest_whole(x);
}

// Given     quarter, one of -2, -1, 0, 1, 2; rest in cycles, |rest| <= 1/8 (a rounding beyond does no harm)
// Returned  cosine and sine of 2 pi (quarter/4 + rest), errors below 2e-16
// Reference polynomials of fdlibm's k_cos.c and k_sin.c (Sun Microsystems, 1993)
static inline void cis_quarters(double quarter, double rest, double &cosine, double &sine) noexcept {
    const double a = rest * 6.283185307179586476925, z = a * a;
    const double s = a + a * z *
                             (-1.66666666666666324348e-01 +
                              z * (8.33333333332248946124e-03 +
                                   z * (-1.98412698298579493134e-04 +
                                        z * (2.75573137070700676789e-06 +
                                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    const double tail = z * z *
                        (4.16666666666666019037e-02 +
                         z * (-1.38888888888741095749e-03 +
                              z * (2.48015872894767294178e-05 +
                                   z * (-2.75573143513906633035e-07 +
                                        z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    const double half = 0.5 * z, most = 1.0 - half;
    const double c = most + (((1.0 - most) - half) + tail);
    const bool odd = quarter == 1.0 || quarter == -1.0, opposite = quarter == 2.0 || quarter == -2.0;
    const double c1 = odd ? s : c, s1 = odd ? c : s;
    cosine = opposite || quarter == 1.0 ? -c1 : c1;
    sine = opposite || quarter == -1.0 ? -s1 : s1;
}

// Given     cycles, |cycles| <= 1/2 (a rounding beyond does no harm)
// Returned  cosine and sine of 2 pi cycles
static inline void cis_cycles(double cycles, double &cosine, double &sine) noexcept {
    const double quarter = nearest_whole(4.0 * cycles);
    cis_quarters(quarter, cycles - 0.25 * quarter, cosine, sine);
}

// a b - p exactly, where p = a b rounded: by FMA or by Dekker's splitting, equal results.
static inline double product_error(double a, double b, double p) noexcept {
#if defined(__FMA__) || defined(__aarch64__)
    return __builtin_fma(a, b, -p);
#else
    constexpr double split = 134217729.0; // 2^27 + 1
    const double ca = split * a, a_high = ca - (ca - a), a_low = a - a_high;
    const double cb = split * b, b_high = cb - (cb - b), b_low = b - b_high;
    return ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low;
#endif
}

// Given     f, t as unevaluated sums, |f t| < 2^51
// Returned  cos and sin of 2 pi f t
static inline void cis_product(double f_high, double f_low, double t_high, double t_low, double &cosine,
                               double &sine) noexcept {
    const double p = f_high * t_high;
    const double rest = product_error(f_high, t_high, p) + (f_high * t_low + f_low * t_high);
    const double r = reduce_cycles(p), quarter = nearest_whole(4.0 * r);
    // From 2^40 cycles on the product's error may take the phase well beyond 1/8: once more then. Else `more` is 0.
    const double part = (r - 0.25 * quarter) + rest, more = nearest_whole(0x1.ff8p1 * part), all = quarter + more;
    cis_quarters(all - 4.0 * nearest_whole(0.25 * all), part - 0.25 * more, cosine, sine);
}

} // namespace toliman::kernels
