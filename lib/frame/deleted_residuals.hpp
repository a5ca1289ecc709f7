// Linear least squares without some of the pixels.
#pragma once
#include <cstddef>

namespace toliman {

// Given     units [count][columns], the rows of an orthonormal basis of the model at `count` <= 32 pixels; residual
//           [count] of the fit to all pixels
// Returned  deleted [count]: the counts of these pixels minus what the fit to all other pixels predicts for them, in
//           the unit of residual. False if the other pixels do not determine the model
// Notes     With H = U U^T, restricted to the pixels, it is (1 - H)^-1 residual. The fit to counts in which these
//           pixels are lowered by `deleted` is the fit to the others alone.
bool deleted_residuals(const double *units, size_t columns, size_t count, const double *residual,
                       double *deleted) noexcept;

} // namespace toliman
