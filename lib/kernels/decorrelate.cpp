// Method: S <- S U^-1 with U^T U = S^T S + ridge (Cholesky QR). The ridge bounds the amplification of weak directions
// of S and keeps the factorisation in float32 from breaking down. Muon (Jordan et al. 2024) orthogonalises momentum by
// a Newton-Schulz iteration instead, which needs only matrix products; with at most 64 columns, one Cholesky
// factorisation of the small Gram matrix does the same.
#include "kernels/decorrelate.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

// Upper triangle of the Gram matrix S^T S.
void products(const float *samples, size_t n, size_t count, float *gram) noexcept {
    for (size_t i = 0; i < count * count; i++)
        gram[i] = 0;
    for (size_t k = 0; k < n; k++, samples += count)
        for (size_t i = 0; i < count; i++)
            for (size_t j = i; j < count; j++)
                gram[i * count + j] += samples[i] * samples[j];
}

// Replaces an upper triangle by its upper Cholesky factor.
void factor(size_t count, float *matrix) noexcept {
    for (size_t i = 0; i < count; i++) {
        float *row = matrix + i * count;
        const float pivot = std::sqrt(row[i]);
        for (size_t j = i; j < count; j++)
            row[j] /= pivot;
        for (size_t k = i + 1; k < count; k++)
            for (size_t j = k; j < count; j++)
                matrix[k * count + j] -= row[k] * row[j];
    }
}

} // namespace

void decorrelate(float *samples, size_t n, size_t count, float *work) noexcept {
    products(samples, n, count, work);
    float trace = 0;
    for (size_t i = 0; i < count; i++)
        trace += work[i * count + i];
    if (!(trace > 0))
        return;
    for (size_t i = 0; i < count; i++)
        work[i * count + i] += kRidge * trace / static_cast<float>(count);
    factor(count, work);
    for (size_t k = 0; k < n; k++, samples += count)
        for (size_t i = 0; i < count; i++) {
            const float *row = work + i * count;
            samples[i] /= row[i];
            for (size_t j = i + 1; j < count; j++)
                samples[j] -= samples[i] * row[j];
        }
}

} // namespace toliman::kernels
