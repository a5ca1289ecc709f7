#include "backend/blas.hpp"

#include <algorithm>
#include <cblas.h>
#include <chrono>

#include "base/buffer.hpp"

namespace toliman::blas {

namespace {
blasint length(size_t n) noexcept {
    return static_cast<blasint>(n);
}
} // namespace

Facts facts() noexcept {
    return {openblas_get_corename(), openblas_get_config(), openblas_get_num_threads()};
}

void dgemm(bool transpose_a, size_t m, size_t n, size_t k, const double *a, size_t lda, const double *b, size_t ldb,
           double *c, size_t ldc) {
    cblas_dgemm(CblasRowMajor, transpose_a ? CblasTrans : CblasNoTrans, CblasNoTrans, length(m), length(n), length(k),
                1.0, a, length(lda), b, length(ldb), 0.0, c, length(ldc));
}

namespace {
// Best of some products of m x k and k x n.
double measure(size_t m, size_t n, size_t k, int times) {
    const Buffer<double> a(m * k, 1.0), b(k * n, 0.5);
    Buffer<double> c(m * n);
    double best = 0;
    for (int i = 0; i < times; i++) {
        const auto start = std::chrono::steady_clock::now();
        dgemm(false, m, n, k, a.data(), k, b.data(), n, c.data(), n);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        best = std::max(best, 2e-9 * static_cast<double>(m * n * k) / seconds.count());
    }
    return best;
}
} // namespace

double measure_gflops() {
    return measure(512, 512, 512, 8);
}

double measure_tile_gflops() {
    return measure(64, 32, 128, 100);
}

} // namespace toliman::blas
