#include "kernels/decorrelate.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

// Upper triangle of the Gram matrix.
void products(const float *samples, size_t n, size_t count, float *gram) noexcept {
    for (size_t i = 0; i < count * count; i++)
        gram[i] = 0;
    for (size_t k = 0; k < n; k++, samples += count)
        for (size_t i = 0; i < count; i++)
            for (size_t j = i; j < count; j++)
                gram[i * count + j] += samples[i] * samples[j];
}

// Upper Cholesky factor in place of an upper triangle.
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
