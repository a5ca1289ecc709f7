// Method: the Gram matrix X X^T of N residual frames, minus their mean, in double precision. Its blocks of 256 x 256
// are independent jobs; each is accumulated over slabs of 64 pixels in tiles of 64 x 64 x 64 = 2^18 multiply-adds,
// which OpenBLAS always runs on the calling thread. A product that it splits over threads is rounded differently, so
// the bits would depend on the number of threads.
#include <algorithm>

#include "backend/blas.hpp"
#include "base/workers.hpp"
#include "linear/residuals.hpp"

namespace toliman::linear {

namespace {

constexpr size_t kBlock = 256, kTile = 64, kDepth = 64;

// A block's rows of residuals minus their mean, as double: `depth` pixels of each, from `first`.
struct Slab {
    Buffer<double> values = Buffer<double>(kBlock * kDepth);

    void load(const float *rows, size_t count, size_t stride, const double *mean, size_t first, size_t depth) noexcept {
        for (size_t r = 0; r < count; r++)
            for (size_t p = 0; p < depth; p++)
                values[r * kDepth + p] = static_cast<double>(rows[r * stride + first + p]) - mean[first + p];
    }
};

// out [m][n], rows `stride` apart, += left right^T; of a block on the diagonal only the tiles on and below it.
void add_products(const Slab &left, size_t m, const Slab &right, size_t n, size_t depth, bool diagonal, double *out,
                  size_t stride) {
    for (size_t i = 0; i < m; i += kTile)
        for (size_t j = 0; j < n && !(diagonal && j > i); j += kTile)
            blas::dgemm_add(std::min(kTile, m - i), std::min(kTile, n - j), depth, &left.values[i * kDepth], kDepth,
                            &right.values[j * kDepth], kDepth, out + i * stride + j, stride);
}

void mirror(Buffer<double> &matrix, size_t n) noexcept {
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            matrix[j * n + i] = matrix[i * n + j];
}

} // namespace

Buffer<double> Residuals::mean() const {
    Buffer<double> mean(pixels_);
    const size_t n = frames();
    for (size_t f = 0; f < n; f++)
        for (size_t p = 0; p < pixels_; p++)
            mean[p] += static_cast<double>(values_[f * pixels_ + p]);
    for (double &value : mean)
        value /= static_cast<double>(n);
    return mean;
}

Buffer<double> Residuals::gram(unsigned workers, const std::function<void(double)> &after_own) const {
    const size_t n = frames(), blocks = (n + kBlock - 1) / kBlock;
    const Buffer<double> mean = this->mean();
    Buffer<double> out(checked_product(n, n, "products of frames"));
    std::vector<std::pair<size_t, size_t>> jobs;
    for (size_t i = 0; i < blocks; i++)
        for (size_t j = 0; j <= i; j++)
            jobs.emplace_back(i * kBlock, j * kBlock);
    run_jobs(
        workers, jobs.size(),
        [&](size_t job) {
            const auto [row, col] = jobs[job];
            const size_t m = std::min(kBlock, n - row), k = std::min(kBlock, n - col);
            Slab left, right;
            for (size_t first = 0; first < pixels_; first += kDepth) {
                const size_t depth = std::min(kDepth, pixels_ - first);
                left.load(&values_[row * pixels_], m, pixels_, mean.data(), first, depth);
                if (row != col)
                    right.load(&values_[col * pixels_], k, pixels_, mean.data(), first, depth);
                add_products(left, m, row != col ? right : left, k, depth, row == col, &out[row * n + col], n);
            }
        },
        after_own);
    mirror(out, n);
    return out;
}

} // namespace toliman::linear
