// Method: S <- S U^-1 with U^T U = S^T S + ridge (Cholesky QR). The ridge bounds the amplification of weak directions
// of S and keeps the factorisation in float32 from breaking down. Muon (Jordan et al. 2024) orthogonalises momentum by
// a Newton-Schulz iteration instead, which needs only matrix products; with at most 64 columns, one Cholesky
// factorisation of the small Gram matrix does the same. Vectors run along rows and every sum has a fixed order, without
// contraction: the same bits on every instruction set.
#include "kernels/decorrelate.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

// Vectors of columns: of eight, or of one if their number is not a multiple of eight. Loops over the columns from i on
// start with the vector that contains i; elements below the diagonal are computed, but not used.
struct Eight {
    typedef float Vector __attribute__((vector_size(32), aligned(4), may_alias));
    static constexpr size_t count = 8;
};
struct One {
    typedef float Vector;
    static constexpr size_t count = 1;
};
template <class V> constexpr size_t start_of(size_t i) noexcept {
    return i / V::count * V::count;
}
// Pointers: clang takes a reference to be aligned as the vector, not as its typedef.
template <class V> typename V::Vector *at(float *from) noexcept {
    return reinterpret_cast<typename V::Vector *>(from);
}
template <class V> const typename V::Vector *at(const float *from) noexcept {
    return reinterpret_cast<const typename V::Vector *>(from);
}

constexpr size_t kSamples = 8; // in turn, so that their chains of operations overlap

// Adds N samples to the upper triangle of the Gram matrix, one after the other.
template <class V, size_t N> void add_samples(const float *samples, size_t count, float *gram) noexcept {
    for (size_t i = 0; i < count; i++)
        for (size_t j = start_of<V>(i); j < count; j += V::count) {
            typename V::Vector sum = *at<V>(gram + i * count + j);
            for (size_t k = 0; k < N; k++)
                sum += samples[k * count + i] * *at<V>(samples + k * count + j);
            *at<V>(gram + i * count + j) = sum;
        }
}

// Replaces an upper triangle by its upper Cholesky factor, with zeros below the diagonal.
template <class V> void factor(size_t count, float *matrix) noexcept {
    for (size_t i = 0; i < count; i++) {
        float *row = matrix + i * count;
        const float pivot = __builtin_sqrtf(row[i]);
        for (size_t j = 0; j < i; j++)
            row[j] = 0;
        for (size_t j = start_of<V>(i); j < count; j += V::count)
            *at<V>(row + j) /= pivot;
        for (size_t k = i + 1; k < count; k++)
            for (size_t j = start_of<V>(k); j < count; j += V::count)
                *at<V>(matrix + k * count + j) -= row[k] * *at<V>(row + j);
    }
}

// s <- s U^-1 of N samples, by substitution: element i is final when those before it have been subtracted from it.
template <class V, size_t N> void solve(size_t count, const float *factor, float *samples) noexcept {
    for (size_t i = 0; i < count; i++) {
        const float *row = factor + i * count;
        float value[N];
        for (size_t k = 0; k < N; k++)
            value[k] = samples[k * count + i] / row[i];
        for (size_t j = start_of<V>(i); j < count; j += V::count)
            for (size_t k = 0; k < N; k++)
                *at<V>(samples + k * count + j) -= value[k] * *at<V>(row + j);
        for (size_t k = 0; k < N; k++)
            samples[k * count + i] = value[k];
    }
}

template <class V> void decorrelate(float *samples, size_t n, size_t count, float *work) noexcept {
    const size_t whole = n / kSamples * kSamples;
    for (size_t i = 0; i < count * count; i++)
        work[i] = 0;
    for (size_t k = 0; k < whole; k += kSamples)
        add_samples<V, kSamples>(samples + k * count, count, work);
    for (size_t k = whole; k < n; k++)
        add_samples<V, 1>(samples + k * count, count, work);
    float trace = 0;
    for (size_t i = 0; i < count; i++)
        trace += work[i * count + i];
    if (!(trace > 0))
        return;
    for (size_t i = 0; i < count; i++)
        work[i * count + i] += kRidge * trace / static_cast<float>(count);
    factor<V>(count, work);
    for (size_t k = 0; k < whole; k += kSamples)
        solve<V, kSamples>(count, work, samples + k * count);
    for (size_t k = whole; k < n; k++)
        solve<V, 1>(count, work, samples + k * count);
}

void decorrelate_any(float *samples, size_t n, size_t count, float *work) noexcept {
    (count % Eight::count == 0 ? decorrelate<Eight> : decorrelate<One>)(samples, n, count, work);
}

} // namespace
} // namespace TOLIMAN_ISA

const DecorrelateKernels TOLIMAN_ISA_TABLE(decorrelate) = {TOLIMAN_ISA::decorrelate_any};

} // namespace toliman::kernels
