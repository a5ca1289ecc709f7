// OpenBLAS: the GEMM and the facts about its kernels.
#pragma once
#include <cstddef>

namespace toliman::blas {

struct Facts {
    const char *core;   // kernels in use
    const char *config; // version and build options
    int threads;        // of one call
};
Facts facts() noexcept;

// Best of a few 512^3 products, in GFLOP/s.
double measure_gflops();

// C (m x n, row stride ldc) = op(A) B, A is m x k (or k x m when transposed), B is k x n (or n x k when transposed).
void dgemm(bool transpose_a, bool transpose_b, size_t m, size_t n, size_t k, const double *a, size_t lda,
           const double *b, size_t ldb, double *c, size_t ldc);

} // namespace toliman::blas
