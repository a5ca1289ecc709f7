// From the pupil to the focus, all but the products: the fields of a star in one wavelength, folded about the axes; the
// operands that transform them; and intensities with their derivatives.
//
// With grids symmetric about 0 the even and odd parts of a plane meet cosines and sines only, so the transform becomes
// real products of a quarter of the size. A folded axis of n samples has half(n) = (n + 1) / 2 of them, at coordinates
// 0.5, 1.5, ... (even n) or 0, 1, ... (odd n), in samples.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

static constexpr size_t half(size_t n) noexcept {
    return (n + 1) / 2;
}

// A field made from an earlier one: i (slope_x x + slope_y y + mode) times it, x and y in samples from the centre. It
// is the derivative by whatever adds such a phase (rad).
struct FieldTerm {
    size_t parent;
    double slope_x, slope_y;
    const double *mode; // [n][n], rad; NULL for none
    double mode_scale;  // multiplies it
};

// image += factor Re(p conj q) of two fields.
struct FieldProduct {
    size_t image, p, q;
    double factor;
};

struct FieldKernels {
    // Given     samples, pixels of the full axes, below 2^13 both; step: phase in cycles of one sample times one pixel
    // Returned  cosine, sine [half(samples)][half(pixels)] of 2 pi x u step
    // Notes     The step is cut into two parts of 24 bits, which times any x u are exact, and a rest: phases of 1e4
    //           cycles come out within 1e-16 of a cycle.
    void (*operand)(size_t samples, size_t pixels, long double step, double *cosine, double *sine) noexcept;

    // Given     amplitude, opd_m [n][n]; wavenumber 1/lambda (1/m); tilt_x, tilt_y [n], cycles in [-1/2, 1/2], the
    //           tilt's phase of each column and row; terms [count - 1]; scratch [4 count n]
    // Returned  even, odd [count][half(n)][4][half(n)]: the fields' parts even and odd in x; in a row y stand the
    //           parts even in y (real, imaginary), then those odd in y. Field 0 is
    //           amplitude exp(2 pi i (opd/lambda + tilt_x + tilt_y)), field k is made by terms[k - 1].
    // Notes     Phases are reduced to half a cycle before any sine, so that large tilts cost no accuracy.
    void (*fold)(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
                 const double *tilt_y, const FieldTerm *terms, size_t count, double *scratch, double *even,
                 double *odd) noexcept;

    // Given     sums [4] = ee, eo, oe, oo, each [count][half(rows)][2][half(cols)] (real, imaginary): sums of the parts
    //           of the fields even or odd in y (first letter) and x (second) times cosines for even and sines for odd;
    //           products; scratch [2 count cols]
    // Returned  images, each [rows][cols], increased by the products of F = sum E exp(-2 pi i (x u + y v) step)
    void (*accumulate)(const double *const *sums, size_t count, size_t rows, size_t cols, const FieldProduct *products,
                       size_t product_count, double *scratch, double *const *images) noexcept;
};
TOLIMAN_ISA_DECLARE(FieldKernels, field)

} // namespace toliman::kernels
