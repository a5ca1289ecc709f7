#include "backend/blas.hpp"

#include <algorithm>
#include <cblas.h>
#include <chrono>

#include "base/buffer.hpp"

namespace toliman::blas {

namespace {
CBLAS_TRANSPOSE flag(bool transpose) noexcept {
    return transpose ? CblasTrans : CblasNoTrans;
}
blasint length(size_t n) noexcept {
    return static_cast<blasint>(n);
}
} // namespace

Facts facts() noexcept {
    return {openblas_get_corename(), openblas_get_config(), openblas_get_num_threads()};
}

void dgemm(bool transpose_a, bool transpose_b, size_t m, size_t n, size_t k, const double *a, size_t lda,
           const double *b, size_t ldb, double *c, size_t ldc) {
    cblas_dgemm(CblasRowMajor, flag(transpose_a), flag(transpose_b), length(m), length(n), length(k), 1.0, a,
                length(lda), b, length(ldb), 0.0, c, length(ldc));
}

double measure_gflops() {
    constexpr size_t n = 512;
    const Buffer<double> a(n * n, 1.0), b(n * n, 0.5);
    Buffer<double> c(n * n);
    double best = 0;
    for (int i = 0; i < 8; i++) {
        const auto start = std::chrono::steady_clock::now();
        dgemm(false, false, n, n, n, a.data(), n, b.data(), n, c.data(), n);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        best = std::max(best, 2e-9 * n * n * n / seconds.count());
    }
    return best;
}

} // namespace toliman::blas
