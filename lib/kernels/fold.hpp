// Operands of the matrix Fourier transform, folded about the axes: with grids that are symmetric about 0, the even and
// odd parts of a plane meet cosines and sines only, so the transform becomes real products of a quarter of the size.
//
// A folded axis of n samples has half(n) = (n + 1) / 2 of them, at coordinates 0.5, 1.5, ... (even n) or 0, 1, ...
// (odd n), in samples.
#pragma once
#include <cstddef>

#include "kernels/field.hpp"

namespace toliman::kernels {

constexpr size_t half(size_t n) noexcept {
    return (n + 1) / 2;
}

// Given     samples, pixels of the full axes; step: phase in cycles of the first sample times the first pixel
// Returned  cosine, sine [half(samples)][half(pixels)] of 2 pi x u step
// Notes     phases are formed in long double and reduced to half a cycle, so that none of 1e4 cycles is off by 1e-15.
void fourier_operand(size_t samples, size_t pixels, long double step, double *cosine, double *sine) noexcept;

// Given     field [n][n]
// Returned  even, odd [half(n)][4][half(n)]: the parts of the field that are even and odd in x; in a row y stand the
//           parts even in y (real, imaginary), then those odd in y
void fold(Field field, size_t n, double *even, double *odd) noexcept;

// Given     ee, eo, oe, oo [half(rows)][2][half(cols)] (real, imaginary): sums of the parts of a pupil's field, even or
//           odd in y (first letter) and x (second), times cosines for even and sines for odd
// Returned  field [rows][cols] = sum E exp(-2 pi i (x u + y v) step)
void unfold(const double *ee, const double *eo, const double *oe, const double *oo, size_t rows, size_t cols,
            Field field) noexcept;

} // namespace toliman::kernels
