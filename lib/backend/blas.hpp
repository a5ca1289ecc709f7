// OpenBLAS: matrix products, LAPACK's eigenvectors, and properties of the library in use.
#pragma once
#include <cstddef>

namespace toliman::blas {

struct Properties {
    const char *core;   // kernels in use
    const char *config; // version and build options
    int threads;        // that one call may use
};
Properties properties() noexcept;

// The OPENBLAS_CORETYPE whose vectors have this many bits; "" if those of `core` are not shorter, and for other widths
// than 256 and 512.
const char *better_core(const char *core, int bits) noexcept;

// Speed of products of 64 x 128 and 128 x 32 matrices, the tiles of larger products, in GFLOP/s: the best of 100; takes
// a millisecond.
double measure_tile_gflops();

// C (m x n, row stride ldc) = op(A) B; A is m x k (or k x m when transposed), B is k x n.
void dgemm(bool transpose_a, size_t m, size_t n, size_t k, const double *a, size_t lda, const double *b, size_t ldb,
           double *c, size_t ldc);

// C (m x n) += A B^T; A is m x k, B is n x k.
void dgemm_add(size_t m, size_t n, size_t k, const double *a, size_t lda, const double *b, size_t ldb, double *c,
               size_t ldc);

// The `count` <= n largest eigenvalues of a symmetric matrix [n][n], which is overwritten: values [count], decreasing,
// and unit vectors [count][n]. Backward error: they are exact for a matrix within about n 2^-53 |matrix| of the given
// one. Uses OpenBLAS's threads; their number may change the last bits.
void leading_eigenvectors(size_t n, double *matrix, size_t count, double *values, double *vectors);

} // namespace toliman::blas
