// OpenBLAS's settings belong to the host program: the number of threads and the choice of kernels are only read. A
// library that changed them would change the host's other results and speed.
//
// Slow OpenBLAS kernels: OpenBLAS selects its kernels by CPU model when it is loaded, and a library older than the CPU
// may fall back to an older core with narrower vectors. The vector width of the selected core, known by its name, and
// the CPU's instruction set tell the OPENBLAS_CORETYPE to set.
#include "backend/blas.hpp"

#include <algorithm>
#include <cblas.h>
#include <chrono>
#include <cstring>
#include <initializer_list>
#include <lapacke.h>

#include "base/buffer.hpp"

namespace toliman::blas {

namespace {
blasint length(size_t n) noexcept {
    return static_cast<blasint>(n);
}

// Vector width in bits of the OpenBLAS kernels of this name.
int vector_bits(const char *core) noexcept {
    for (const char *name : {"SkylakeX", "Cooperlake", "SapphireRapids"})
        if (std::strcmp(core, name) == 0)
            return 512;
    for (const char *name : {"Haswell", "Zen", "Excavator", "Sandybridge", "Bulldozer", "Piledriver", "Steamroller"})
        if (std::strcmp(core, name) == 0)
            return 256;
    return 128;
}

// OpenBLAS writes its configuration into one buffer at each call: that of two threads would be mixed.
struct Configuration {
    Configuration() noexcept { std::strncpy(text, openblas_get_config(), sizeof text - 1); }
    char text[256] = "";
};
} // namespace

const char *better_core(const char *core, int bits) noexcept {
    if (bits == 512 && vector_bits(core) < 512)
        return "SkylakeX";
    return bits == 256 && vector_bits(core) < 256 ? "Haswell" : "";
}

Properties properties() noexcept {
    static const Configuration configuration;
    return {openblas_get_corename(), configuration.text, openblas_get_num_threads()};
}

void dgemm(bool transpose_a, size_t m, size_t n, size_t k, const double *a, size_t lda, const double *b, size_t ldb,
           double *c, size_t ldc) {
    cblas_dgemm(CblasRowMajor, transpose_a ? CblasTrans : CblasNoTrans, CblasNoTrans, length(m), length(n), length(k),
                1.0, a, length(lda), b, length(ldb), 0.0, c, length(ldc));
}

void dgemm_add(size_t m, size_t n, size_t k, const double *a, size_t lda, const double *b, size_t ldb, double *c,
               size_t ldc) {
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, length(m), length(n), length(k), 1.0, a, length(lda), b,
                length(ldb), 1.0, c, length(ldc));
}

// LAPACK's dsyevr (relatively robust representations), which can compute a range of eigenvalues only. It numbers them
// from 1 in increasing order; the results are reversed. The first call asks for the size of the work arrays. OpenBLAS
// contains dsyevr; only its declaration comes from lapacke.h.
void leading_eigenvectors(size_t n, double *matrix, size_t count, double *values, double *vectors) {
    const lapack_int order = length(n), first = length(n - count + 1), none = -1;
    const double unused = 0;
    lapack_int found = 0, info = 0, integers_needed = 0;
    double needed = 0;
    Buffer<double> all(n), space(1);
    Buffer<lapack_int> support(2 * count), integers(1);
    const auto call = [&](double *work, lapack_int size, lapack_int *iwork, lapack_int isize) {
        LAPACK_dsyevr("V", "I", "L", &order, matrix, &order, &unused, &unused, &first, &order, &unused, &found,
                      all.data(), vectors, &order, support.data(), work, &size, iwork, &isize, &info);
    };
    call(&needed, none, &integers_needed, none);
    space.resize(static_cast<size_t>(needed));
    integers.resize(static_cast<size_t>(integers_needed));
    call(space.data(), length(space.size()), integers.data(), integers_needed);
    if (info != 0 || found != length(count))
        fail(Status::internal, "LAPACK dsyevr: info = %d, found %d of %zu eigenvectors", info, found, count);
    std::reverse_copy(all.begin(), all.begin() + found, values);
    for (size_t i = 0, j = count - 1; i < j; i++, j--)
        std::swap_ranges(vectors + i * n, vectors + (i + 1) * n, vectors + j * n);
}

double measure_tile_gflops() {
    constexpr size_t m = 64, n = 32, k = 128;
    const Buffer<double> a(m * k, 1.0), b(k * n, 0.5);
    Buffer<double> c(m * n);
    double best = 0;
    for (int i = 0; i < 100; i++) {
        const auto start = std::chrono::steady_clock::now();
        dgemm(false, m, n, k, a.data(), k, b.data(), n, c.data(), n);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        best = std::max(best, 2e-9 * static_cast<double>(m * n * k) / seconds.count());
    }
    return best;
}

} // namespace toliman::blas
