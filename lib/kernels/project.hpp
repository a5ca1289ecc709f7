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

// Given     units, vector as of project_out
// Returned  vector less its components along them; its length before and after
// Notes     Projects twice, as the first pass leaves its own rounding behind. What is left below kRounding of the
//           length is rounding, and `after` then 0.
constexpr double kRounding = 1e-10;
struct Lengths {
    double before, after;
};
Lengths project_out_twice(const double *units, size_t count, size_t n, double *vector) noexcept;

// Given     vectors [count][n]
// Returned  the first r rows: an orthonormal basis of their span; r itself
// Notes     Gram-Schmidt done twice; a vector that loses all but kRounding of its length to the others is dropped.
size_t orthonormalise(double *vectors, size_t count, size_t n) noexcept;

} // namespace toliman::kernels
