// Small symmetric systems.
#pragma once
#include <cstddef>

namespace toliman {

// Replaces a symmetric positive definite matrix [n][n], of which the upper triangle is read, by its inverse. False,
// with the matrix overwritten, if it is singular: if a parameter is a combination of the others to 1e-12 of its
// variance. Allocates memory for n above 32 only.
bool invert_symmetric(double *matrix, size_t n);

} // namespace toliman
