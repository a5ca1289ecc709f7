// Cosine and sine of a phase in cycles.
#pragma once

namespace toliman::kernels {

// x less the nearest whole number, exact; |x| < 2^51.
inline double reduce_cycles(double x) noexcept {
    return x - ((x + 0x1.8p52) - 0x1.8p52);
}

// Given     cycles, |cycles| <= 1/2 (a rounding beyond does no harm)
// Returned  cosine and sine of 2 pi cycles, errors below 2e-16
// Notes     no branch and no libm: the loops around it vectorise, and every machine computes the same bits.
// Reference polynomials of fdlibm's kernels (Sun Microsystems, 1993)
inline void cis_cycles(double cycles, double &cosine, double &sine) noexcept {
    const double quarter = (4.0 * cycles + 0x1.8p52) - 0x1.8p52;
    const double a = (cycles - 0.25 * quarter) * 6.283185307179586476925, z = a * a;
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
    cosine = odd ? (quarter > 0 ? -s : s) : (opposite ? -c : c);
    sine = odd ? (quarter > 0 ? c : -c) : (opposite ? -s : s);
}

} // namespace toliman::kernels
