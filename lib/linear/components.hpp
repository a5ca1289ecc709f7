// Components of a set of frames, from the frames' inner products alone: whatever lies in the span of N frames can be
// written in N numbers, so that no step has to touch the pixels.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/progress.hpp"

namespace toliman::linear {

struct Components {
    size_t frames = 0;
    Buffer<double> series; // [count][frames]; its element of largest magnitude, the first of equals, is positive
    Buffer<double> share;  // [count], of the frames' sum of squares
    size_t iterations = 0; // of the dictionary
    bool converged = true;
    double objective = 0; // of the dictionary, over that of no atoms
};

// Principal components. gram [frames][frames] is overwritten. Series j is sqrt(eigenvalue) times eigenvector, the
// residuals' component along the j-th principal image; an eigenvalue that is rounding counts as 0. Where eigenvalues
// are equal the basis of their space is LAPACK's.
Components principal_components(size_t frames, Buffer<double> gram, size_t count);

struct DictionaryOptions {
    size_t count = 1;
    double lambda = 1;       // weight of the codes' L1 norm, in rms pixels
    size_t iterations = 200; // at most
    uint64_t seed = 0;       // of the start
    Progress progress;
};

// Sparse dictionary: codes a and atoms D, |D_j| <= 1, of least sum of |x - D a|^2 / 2 + lambda rms |a|_1, alternately
// improved from random atoms in the frames' span: codes by coordinate descent, atoms by block coordinate descent.
// It ends where a step adds less than 1e-5 of what was gained; such an end is no global minimum. Series are codes,
// the one of largest energy first. `pixels` is what gram was summed over.
// Reference  Mairal, Bach, Ponce, Sapiro (2009), algorithms 1 and 2, all frames at once
Components sparse_dictionary(size_t frames, const Buffer<double> &gram, size_t pixels,
                             const DictionaryOptions &options);

// Signs, as promised by Components.
void fix_signs(Components &components) noexcept;

} // namespace toliman::linear
