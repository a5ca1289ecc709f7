// Regularised orthonormalisation of vectors, float32: the step direction of tied training.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr float kRidge = 0.1f;

struct DecorrelateKernels {
    // Given     samples [n][count], a matrix S of `count` column vectors; work [count][count]
    // Returned  S U^-1, where G = S^T S is the Gram matrix and U^T U = G + kRidge trace(G)/count I its regularised
    //           Cholesky factorisation. For kRidge = 0 the columns would be orthonormal. Weak directions stay shorter
    //           than 1. A zero matrix is returned unchanged.
    // Notes     Every sum runs in a fixed order: the same bits on every instruction set.
    // Reference Jordan et al. (2024), "Muon: an optimizer for hidden layers in neural networks"
    void (*decorrelate)(float *samples, size_t n, size_t count, float *work) noexcept;
};
TOLIMAN_ISA_DECLARE(DecorrelateKernels, decorrelate)

} // namespace toliman::kernels
