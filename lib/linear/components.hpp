// Principal components and sparse dictionaries of a set of frames, from their Gram matrix alone.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/progress.hpp"

namespace toliman::linear {

struct Components {
    size_t frames = 0;
    Buffer<double> series; // [count][frames]; the sign makes the element of largest magnitude (the first such) positive
    Buffer<double> share;  // [count], fraction of the frames' total sum of squares
    size_t iterations = 0; // dictionary only
    bool converged = true; // dictionary only
    double objective = 0;  // dictionary only: relative to the objective without atoms
};

// Principal components of `frames` residuals with the Gram matrix gram [frames][frames]. Series j is sqrt(eigenvalue)
// times eigenvector: the residuals' components along the j-th principal image. Eigenvalues below rounding count as 0.
// For equal eigenvalues the basis of their eigenspace is LAPACK's.
Components principal_components(size_t frames, Buffer<double> gram, size_t count);

struct DictionaryOptions {
    size_t count = 1;
    double lambda = 1;       // weight of the codes' L1 norm, in units of the rms of a pixel
    size_t iterations = 200; // maximum
    uint64_t seed = 0;       // of the initial atoms
    Progress progress;
};

// Sparse dictionary (dictionary.cpp) of frames with the Gram matrix gram [frames][frames] over `pixels` pixels. Series
// are the codes, that of the largest energy first. The result is a local minimum.
Components sparse_dictionary(size_t frames, const Buffer<double> &gram, size_t pixels,
                             const DictionaryOptions &options);

// Fixes the signs of the series as documented in Components.
void fix_signs(Components &components) noexcept;

} // namespace toliman::linear
