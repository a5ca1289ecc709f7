// Whitening and projection of images as vectors, for optics, cae and linear. Double precision, compensated sums.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

// A compensated inner product in progress: partial sums and, apart, their rounding errors.
constexpr size_t kDotParts = 16;
struct Dot {
    double sum[kDotParts] = {}, error[kDotParts] = {};
    double total() const noexcept;
};

struct ProjectKernels {
    // Given     a, b [n]
    // Returned  dot plus sum a_i b_i. The same bits on every instruction set
    void (*add)(const double *a, const double *b, size_t n, Dot &dot) noexcept;

    // The same for sum (a_i - reference_i) b_i; true if all a are finite.
    bool (*add_difference)(const double *a, const double *reference, const double *b, size_t n, Dot &dot) noexcept;

    // As whiten() below.
    void (*whiten)(const double *image, const double *variance, size_t n, double *out) noexcept;
};
TOLIMAN_ISA_DECLARE(ProjectKernels, project)

// Given     a, b [n]
// Returned  sum a_i b_i, as if computed in twice the working precision and then rounded
// Reference Ogita, Rump, Oishi (2005), algorithm Dot2: error <= eps |a.b| + (n eps)^2 |a|.|b|
double dot(const double *a, const double *b, size_t n) noexcept;

// Given     image [n], variance [n] > 0
// Returned  out [n] = image / sqrt(variance); out may be image
void whiten(const double *image, const double *variance, size_t n, double *out) noexcept;

// Given     basis [count][n], orthonormal; vector [n]
// Returned  vector minus its components along the basis
void project_out(const double *basis, size_t count, size_t n, double *vector) noexcept;

// Given     basis, vector as for project_out
// Returned  vector minus its components along the basis; its norms before and after
// Notes     Projects twice, because the first pass leaves components of the size of its rounding errors. A remainder
//           below kRounding of the norm is rounding noise; `after` is then 0.
// Reference Giraud, Langou and Rozloznik (2005), Comput. Math. Appl. 50, 1069: twice is enough
constexpr double kRounding = 1e-10;
struct Lengths {
    double before, after;
};
Lengths project_out_twice(const double *basis, size_t count, size_t n, double *vector) noexcept;

// Given     vectors [count][n]
// Returned  the first r vectors: an orthonormal basis of the span; r, its dimension
// Notes     Gram-Schmidt with reorthogonalisation. A vector whose remainder is below kRounding of its norm is dropped.
size_t orthonormalise(double *vectors, size_t count, size_t n) noexcept;

} // namespace toliman::kernels
