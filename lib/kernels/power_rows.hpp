// Lomb-Scargle power with nuisance functions from the sums of kernels/push_rows.hpp, vectorised over frequencies.
#pragma once
#include "kernels/push_rows.hpp"

namespace toliman::kernels {

constexpr size_t kMaxRows = 33; // functions, the mean among them

// Quantities common to all frequencies, in units of W.
struct PowerRowsShared {
    double weight;   // W > 0
    int64_t samples; // in [W, 2^32)
    double size;     // root mean square of y
    double spread;   // variance of y that the functions leave
    size_t used;     // functions in use
    size_t function[kMaxRows];
    double factor[kMaxRows][kMaxRows]; // lower triangle of the Cholesky factor L of the Gram matrix
    double inverse[kMaxRows];          // of its diagonal
    double y[kMaxRows];                // L^-1 g_y
};

// Smallest share of cosine and sine that the functions may leave, and smallest determinant cc ss - cs^2 of what is
// left.
constexpr double kLeastRest = 1e-2, kLeastRowsDeterminant = 1e-3;

struct PowerRowsKernels {
    // Given     lo, hi, the sums of a PushRow, each [n]; shared
    // Returned  power [n], in [0, 1], or kNeedsMore (kernels/power.hpp) where double does not suffice; the result is
    // the
    //           number of kNeedsMore. Error: about 1e-15 size/sqrt(spread), divided by the smallest share of a function
    //           that those before it leave
    // Notes     Third limbs, at most 2^-101 samples, are ignored. The same bits on every instruction set.
    size_t (*power)(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerRowsShared &shared,
                    double *power) noexcept;
};
TOLIMAN_ISA_DECLARE(PowerRowsKernels, power_rows)

} // namespace toliman::kernels
