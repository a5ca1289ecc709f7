// Nuisance functions of an archive, prepared for sums in double: orthonormal, and projected out of the values.
#pragma once
#include <vector>

#include "period/batch/archive.hpp"

namespace toliman::period {

struct ArchiveBasis {
    ArchiveBasis(const Archive &archive, const Basis &basis);

    size_t used() const noexcept { return functions.size(); }

    std::vector<Buffer<double>> functions; // w q of each function q in use, [n]; sum w q_i q_j = 1 if i = j, else 0
    Buffer<double> x;                      // w (y - functions)/(standard deviation); see Archive::x
    double largest_sum = 0;                // of |x|
    size_t free = 0;                       // functions in use without a prior
    // Error of the functions and of x relative to their size: rounding errors times the condition of the functions.
    // Infinite if the functions describe the values to rounding.
    double error = 0;
};

// Sets the bounds of the columns to the largest values, and a span that is not given, start = end, to that of the
// samples. Fails for values that are not finite, and for times outside the span.
void complete(Basis &basis, const BatchSamples &samples);

} // namespace toliman::period
