// Element-wise parts of the matrix Fourier transform from pupil to focus: pupil fields of a star at one wavelength,
// folded about the axes; the cosine and sine matrices; intensities and their derivatives. The matrix products
// themselves are done by the caller (OpenBLAS).
//
// On grids symmetric about 0, the even part of a plane is transformed by cosines and the odd part by sines only, so
// that the complex transform becomes real products of a quarter of the size. A folded axis of n samples has half(n) =
// (n + 1)/2 of them, at coordinates 0.5, 1.5, ... (even n) or 0, 1, ... (odd n), in samples.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

static constexpr size_t half(size_t n) noexcept {
    return (n + 1) / 2;
}

// A field derived from an earlier one: i (slope_x x + slope_y y + mode) times it, with x and y in samples from the
// centre. It is the derivative with respect to a parameter that adds this phase (rad), such as a tilt or a wavefront
// mode. Or, with amplitude and opd_m, a field like field 0 of a pupil of its own: the derivative with respect to a
// parameter that changes the transmission.
struct FieldTerm {
    size_t parent; // index of the earlier field
    double slope_x, slope_y;
    const double *mode;                                  // [n][n], rad; NULL for none
    double mode_scale;                                   // factor of mode
    const double *amplitude = nullptr, *opd_m = nullptr; // [n][n], instead of all the above; 0 beyond lit
};

// image += factor Re(p conj q) of two fields.
struct FieldProduct {
    size_t image, p, q;
    double factor;
};

struct FieldKernels {
    // Given     samples, pixels: lengths of the full axes, both below 2^13; step: phase in cycles of one sample times
    //           one pixel
    // Returned  cosine, sine [half(samples)][half(pixels)] of 2 pi x u step
    // Notes     The step is split into two parts of 24 bits, whose products with any x u are exact, and a remainder:
    //           phases of 1e4 cycles are within 1e-16 of a cycle.
    void (*operand)(size_t samples, size_t pixels, long double step, double *cosine, double *sine) noexcept;

    // Given     amplitude, opd_m [n][n]; lit [half(n)], the number of samples of each folded row up to the last with an
    //           amplitude in any quadrant; wavenumber 1/lambda (1/m); tilt_x, tilt_y [n], the tilt's phase of each
    //           column and row in cycles, in [-1/2, 1/2]; terms [count - 1]; scratch [4 count n]
    // Returned  even, odd [count][half(n)][4][half(n)]: the fields' parts even and odd in x. Each row y contains the
    //           part even in y (real, imaginary), then the part odd in y. Field 0 is
    //           amplitude exp(2 pi i (opd/lambda + tilt_x + tilt_y)); field k is derived by terms[k - 1]. Samples
    //           beyond lit are not written: the caller clears them once.
    // Notes     Phases are reduced to half a cycle before any sine, so that large tilts do not reduce the accuracy.
    void (*fold)(const double *amplitude, const double *opd_m, size_t n, const size_t *lit, double wavenumber,
                 const double *tilt_x, const double *tilt_y, const FieldTerm *terms, size_t count, double *scratch,
                 double *even, double *odd) noexcept;

    // Given     sums [4] = ee, eo, oe, oo, each [count][half(rows)][2][half(cols)] (real, imaginary): transforms of the
    //           parts even (e) or odd (o) in y (first letter) and x (second), by cosines for even and sines for odd;
    //           products; scratch [2 count cols]
    // Returned  images, each [rows][cols], increased by the products of F = sum E exp(-2 pi i (x u + y v) step)
    void (*accumulate)(const double *const *sums, size_t count, size_t rows, size_t cols, const FieldProduct *products,
                       size_t product_count, double *scratch, double *const *images) noexcept;
};
TOLIMAN_ISA_DECLARE(FieldKernels, field)

} // namespace toliman::kernels
