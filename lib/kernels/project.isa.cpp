// Method: Dot2, in 16 interleaved partial sums. Each accumulates its products and, apart, their rounding errors and
// those of its additions (two-sum). 16 is fixed, independent of the vector width: every instruction set adds in the
// same order and gives the same bits. Products are split exactly by FMA or by Dekker's splitting (kernels/cis.hpp).
// Reference: Ogita, Rump and Oishi (2005), SIAM J. Sci. Comput. 26, 1955.
#include "kernels/project.hpp"

#include "kernels/cis.hpp"
#include "kernels/finite.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

inline void add_product(double a, double b, double &sum, double &error) noexcept {
    const double product = a * b, next = sum + product, shifted = next - sum;
    error += ((sum - (next - shifted)) + (product - shifted)) + product_error(a, b, product);
    sum = next;
}

// Adds factor_of(i) b_i for i < n to the partial sums.
template <class Factor> inline void add_all(Factor factor_of, const double *b, size_t n, Dot &dot) noexcept {
    double sum[kDotParts], error[kDotParts];
    for (size_t p = 0; p < kDotParts; p++) {
        sum[p] = dot.sum[p];
        error[p] = dot.error[p];
    }
    size_t i = 0;
    for (; i + kDotParts <= n; i += kDotParts)
        for (size_t p = 0; p < kDotParts; p++)
            add_product(factor_of(i + p), b[i + p], sum[p], error[p]);
    for (size_t p = 0; i + p < n; p++)
        add_product(factor_of(i + p), b[i + p], sum[p], error[p]);
    for (size_t p = 0; p < kDotParts; p++) {
        dot.sum[p] = sum[p];
        dot.error[p] = error[p];
    }
}

void add(const double *a, const double *b, size_t n, Dot &dot) noexcept {
    add_all([a](size_t i) { return a[i]; }, b, n, dot);
}

bool add_difference(const double *a, const double *reference, const double *b, size_t n, Dot &dot) noexcept {
    uint64_t bad = 0;
    for (size_t i = 0; i < n; i++)
        bad |= not_finite(a[i]);
    add_all([a, reference](size_t i) { return a[i] - reference[i]; }, b, n, dot);
    return bad == 0;
}

void whiten(const double *image, const double *variance, size_t n, double *out) noexcept {
    constexpr size_t kBlock = 16;
    double block[kBlock]; // since out may be image, compilers do not vectorise a loop that writes to out
    size_t i = 0;
    for (; i + kBlock <= n; i += kBlock) {
        for (size_t p = 0; p < kBlock; p++)
            block[p] = image[i + p] / __builtin_sqrt(variance[i + p]);
        __builtin_memcpy(out + i, block, sizeof block);
    }
    for (; i < n; i++)
        out[i] = image[i] / __builtin_sqrt(variance[i]);
}

} // namespace
} // namespace TOLIMAN_ISA

const ProjectKernels TOLIMAN_ISA_TABLE(project) = {TOLIMAN_ISA::add, TOLIMAN_ISA::add_difference, TOLIMAN_ISA::whiten};

} // namespace toliman::kernels
