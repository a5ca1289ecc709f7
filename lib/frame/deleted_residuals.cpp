// Method: the fit without pixels P is that of a model with one further parameter per pixel of P, which takes its
// residual. Eliminating the model's own parameters leaves (1 - U U^T) d = e for these, with the rows U of an
// orthonormal basis of the model at P (`units`), the residuals e of the fit to all pixels, and the deleted residuals d.
// The matrix is positive definite unless the other pixels leave a parameter undetermined.
// Reference: Cook and Weisberg 1982, Residuals and Influence in Regression, appendix A.2.
#include "frame/deleted_residuals.hpp"

#include "base/symmetric.hpp"
#include "frame/bad_pixels.hpp"

namespace toliman {

bool deleted_residuals(const double *units, size_t columns, size_t count, const double *residual,
                       double *deleted) noexcept {
    double matrix[kMostBadPixels * kMostBadPixels];
    for (size_t i = 0; i < count; i++)
        for (size_t j = i; j < count; j++) {
            double sum = i == j ? 1 : 0;
            for (size_t k = 0; k < columns; k++)
                sum -= units[i * columns + k] * units[j * columns + k];
            matrix[i * count + j] = sum;
        }
    if (!invert_symmetric(matrix, count))
        return false;
    for (size_t i = 0; i < count; i++) {
        deleted[i] = 0;
        for (size_t j = 0; j < count; j++)
            deleted[i] += matrix[i * count + j] * residual[j];
    }
    return true;
}

} // namespace toliman
