#include "backend/blas.hpp"

#include <cblas.h>

namespace toliman::blas {

namespace {
CBLAS_TRANSPOSE flag(bool transpose) noexcept { return transpose ? CblasTrans : CblasNoTrans; }
blasint length(size_t n) noexcept { return static_cast<blasint>(n); }
} // namespace

Facts facts() noexcept { return {openblas_get_corename(), openblas_get_config(), openblas_get_num_threads()}; }

void zgemm(bool transpose_a, bool transpose_b, size_t m, size_t n, size_t k, const std::complex<double> *a, size_t lda,
           const std::complex<double> *b, size_t ldb, std::complex<double> *c, size_t ldc) {
    const std::complex<double> one = 1.0, zero = 0.0;
    cblas_zgemm(CblasRowMajor, flag(transpose_a), flag(transpose_b), length(m), length(n), length(k), &one, a,
                length(lda), b, length(ldb), &zero, c, length(ldc));
}

void dgemm(bool transpose_a, bool transpose_b, size_t m, size_t n, size_t k, const double *a, size_t lda,
           const double *b, size_t ldb, double *c, size_t ldc) {
    cblas_dgemm(CblasRowMajor, flag(transpose_a), flag(transpose_b), length(m), length(n), length(k), 1.0, a,
                length(lda), b, length(ldb), 0.0, c, length(ldc));
}

} // namespace toliman::blas
