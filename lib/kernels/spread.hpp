// Samples at arbitrary times onto an even grid, for a non-uniform Fourier transform.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kSpreadLanes = 16; // of the widest kernel; grids are padded by as many

// Times as unevaluated sums, and what each sample weighs.
struct SpreadSamples {
    const double *t_high, *t_low;
    const double *weights[2]; // as many as there are pairs of grids
    size_t n;
};

// A kernel of odd width w on the cells -(w-1)/2 ... (w-1)/2 about the nearest one. In cell i it is the polynomial
// sum_d coefficients[d * lanes + i] s^d of s = -2 (position - nearest cell), |s| <= 1; 0 in the lanes from w on.
struct SpreadShape {
    size_t width, lanes, degree; // lanes 8, 12 or 16
    const double *coefficients;
};

// Phases that a sample has on the grid: position in `df t` of a turn, strength turned by f t.
struct SpreadPhases {
    double df, f_high, f_low; // f an unevaluated sum
    double cells;             // of a turn, below 2^31
};

struct SpreadKernels {
    // Given     samples, shape, phases with |df t| and |f t| below 2^51; pairs 1 or 2
    // Returned  grids[2 p] and grids[2 p + 1], each [cells + kSpreadLanes], plus weights[p] times cosine and sine of
    //           2 pi f t times the kernel; cells from `cells` on belong to the beginning of the turn
    // Notes     Positions are within 2e-16 of a cell however many turns and cells there are. The same bits on every
    //           instruction set.
    void (*spread)(const SpreadSamples &samples, const SpreadShape &shape, const SpreadPhases &phases, size_t pairs,
                   double *const *grids) noexcept;
};
TOLIMAN_ISA_DECLARE(SpreadKernels, spread)

} // namespace toliman::kernels
