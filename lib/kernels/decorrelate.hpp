// Vectors made orthogonal to each other, float32: the direction in which training turns a matrix of weights.
#pragma once
#include <cstddef>

namespace toliman::kernels {

constexpr float kRidge = 0.1f;

// Given     samples [n][count] of count vectors, side by side; work [count][count]
// Returned  samples of orthonormal vectors with the same span, but for kRidge: with G the vectors' Gram matrix and
//           U^T U = G + kRidge trace(G)/count the Cholesky factors, samples U^-1. Directions in which the vectors have
//           little are therefore not blown up, but stay shorter than 1. Nothing but zeros stays as it is.
// Notes     Every sum runs in a fixed order.
// Reference Jordan et al. (2024), "Muon", who make momentum orthogonal by a Newton-Schulz iteration
void decorrelate(float *samples, size_t n, size_t count, float *work) noexcept;

} // namespace toliman::kernels
