// Whitening and projection of images as vectors, shared by optics, cae and linear. Double, compensated sums.
#pragma once
#include <cstddef>

namespace toliman::kernels {

// Given     a, b [n]
// Returned  sum a_i b_i, as if computed in twice the working precision and then rounded
// Reference Ogita, Rump, Oishi (2005), algorithm Dot2: error <= eps |a.b| + (n eps)^2 |a|.|b|
double dot(const double *a, const double *b, size_t n) noexcept;

// Given     image [n], variance [n] > 0
// Returned  out [n] = image / sqrt(variance); may be the same memory as image
void whiten(const double *image, const double *variance, size_t n, double *out) noexcept;

// Given     units [count][n], orthonormal; vector [n]
// Returned  vector less its components along them
void project_out(const double *units, size_t count, size_t n, double *vector) noexcept;

// Given     vectors [count][n]
// Returned  the first r rows: an orthonormal basis of their span; r itself
// Notes     Gram-Schmidt done twice; a vector that loses all but 1e-10 of its length to the others is dropped.
size_t orthonormalise(double *vectors, size_t count, size_t n) noexcept;

} // namespace toliman::kernels
