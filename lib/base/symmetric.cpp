// Method: Cholesky's factorisation of the matrix scaled to a unit diagonal, and the inverse of the factor. Parameters
// differ by many orders of magnitude in their units; scaled, the condition number is that of the correlations alone.
#include "base/symmetric.hpp"

#include <cmath>
#include <vector>

namespace toliman {

namespace {

constexpr size_t kFew = 32;
constexpr double kLeastPivot = 1e-12; // 1 - R^2 of a parameter on those before it

} // namespace

bool invert_symmetric(double *matrix, size_t n) {
    double few[kFew];
    std::vector<double> many(n > kFew ? n : 0);
    double *const scale = many.empty() ? few : many.data();
    for (size_t i = 0; i < n; i++) {
        if (!(matrix[i * n + i] > 0) || !std::isfinite(matrix[i * n + i]))
            return false;
        scale[i] = 1 / std::sqrt(matrix[i * n + i]);
    }
    // The lower triangle becomes L, then its inverse.
    for (size_t j = 0; j < n; j++)
        for (size_t i = j; i < n; i++) {
            double sum = matrix[j * n + i] * scale[i] * scale[j];
            for (size_t k = 0; k < j; k++)
                sum -= matrix[i * n + k] * matrix[j * n + k];
            if (i == j && !(sum > kLeastPivot))
                return false;
            matrix[i * n + j] = i == j ? std::sqrt(sum) : sum / matrix[j * n + j];
        }
    for (size_t j = 0; j < n; j++) {
        matrix[j * n + j] = 1 / matrix[j * n + j];
        for (size_t i = j + 1; i < n; i++) {
            double sum = 0;
            for (size_t k = j; k < i; k++)
                sum -= matrix[i * n + k] * matrix[k * n + j];
            matrix[i * n + j] = sum / matrix[i * n + i];
        }
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = i; j < n; j++) {
            double sum = 0;
            for (size_t k = j; k < n; k++)
                sum += matrix[k * n + i] * matrix[k * n + j];
            matrix[i * n + j] = sum * scale[i] * scale[j]; // read no more as the lower triangle of a row above
        }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            matrix[i * n + j] = matrix[j * n + i];
    return true;
}

} // namespace toliman
