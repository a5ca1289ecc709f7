// Cosine and sine of a phase in cycles, without branches and without libm: loops vectorise, and every machine computes
// the same bits. libm's sine differs between versions and CPUs, and reduces large arguments in radians, with an
// irrational period; a phase in cycles is reduced exactly by subtracting the nearest integer.
//
// All functions are static, so that each file keeps the copy of its own instruction set (kernels/isa.hpp).
#pragma once

namespace toliman::kernels {

// The integer nearest to x, ties to even; |x| < 2^51. Adding 1.5 x 2^52 leaves no mantissa bits for a fraction.
static inline double nearest_whole(double x) noexcept {
    return (x + 0x1.8p52) - 0x1.8p52;
}

// x minus the nearest integer, exact; |x| < 2^51.
static inline double reduce_cycles(double x) noexcept {
    return x - nearest_whole(x);
}

// Given     quarter, one of -2, -1, 0, 1, 2; part in cycles, |part| <= 1/8 up to rounding
// Returned  cosine and sine of 2 pi (quarter/4 + part), with errors below 2e-16
// Reference polynomials of fdlibm's k_cos.c and k_sin.c (Sun Microsystems, 1993)
static inline void cis_quarters(double quarter, double part, double &cosine, double &sine) noexcept {
    const double a = part * 6.283185307179586476925, z = a * a;
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
    const double half = 0.5 * z, leading = 1.0 - half; // 1 - z/2 as leading + its rounding error
    const double c = leading + (((1.0 - leading) - half) + tail);
    const bool odd = quarter == 1.0 || quarter == -1.0, opposite = quarter == 2.0 || quarter == -2.0;
    const double c1 = odd ? s : c, s1 = odd ? c : s;
    cosine = opposite || quarter == 1.0 ? -c1 : c1;
    sine = opposite || quarter == -1.0 ? -s1 : s1;
}

// Given     cycles, |cycles| <= 1/2 up to rounding
// Returned  cosine and sine of 2 pi cycles
static inline void cis_cycles(double cycles, double &cosine, double &sine) noexcept {
    const double quarter = nearest_whole(4.0 * cycles);
    cis_quarters(quarter, cycles - 0.25 * quarter, cosine, sine);
}

// Given     a, b and p = a b, rounded
// Returned  a b - p, exact: by FMA or by Dekker's splitting, with equal results
// Reference Dekker (1971), Numer. Math. 18, 224
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
// Returned  cosine and sine of 2 pi f t, within 2e-16
static inline void cis_product(double f_high, double f_low, double t_high, double t_low, double &cosine,
                               double &sine) noexcept {
    const double p = f_high * t_high;
    const double error = product_error(f_high, t_high, p) + (f_high * t_low + f_low * t_high);
    const double r = reduce_cycles(p), quarter = nearest_whole(4.0 * r);
    // From 2^40 cycles on the product's error can move the phase well beyond 1/8: it is then reduced again by `more`
    // quarters. Otherwise `more` is 0.
    const double part = (r - 0.25 * quarter) + error, more = nearest_whole(0x1.ff8p1 * part), all = quarter + more;
    cis_quarters(all - 4.0 * nearest_whole(0.25 * all), part - 0.25 * more, cosine, sine);
}

} // namespace toliman::kernels
