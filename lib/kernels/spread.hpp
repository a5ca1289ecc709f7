// Spreading: adds samples at arbitrary times to an equidistant grid, the first step of a non-uniform FFT of type 1.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kSpreadLanes = 16; // lanes of the widest kernel; grids have this much padding

// Times as unevaluated sums, and one or two weights per sample.
struct SpreadSamples {
    const double *t_high, *t_low;
    const double *weights[2]; // one per pair of grids
    size_t n;
};

// Spreading kernel of odd width w, on the cells -(w-1)/2 ... (w-1)/2 around the nearest one. In cell i it is the
// polynomial sum_d coefficients[d * lanes + i] s^d with s = -2 (position - nearest cell), |s| <= 1; 0 in lanes w and
// above.
struct SpreadShape {
    size_t width, lanes, degree; // lanes 8, 12 or 16
    const double *coefficients;
};

// Maps times to the grid: the position is the fractional part of df t, the strength is multiplied by exp(2 pi i f t).
struct SpreadPhases {
    double df, f_high, f_low; // f an unevaluated sum
    double cells;             // cells per period of the grid, below 2^31
};

struct SpreadKernels {
    // Given     samples, shape, phases with |df t| and |f t| below 2^51; pairs 1 or 2
    // Returned  grids[2 p] and grids[2 p + 1], each [cells + kSpreadLanes], increased by weights[p] times cosine and
    //           sine of 2 pi f t times the kernel. The grid is periodic: the caller adds the cells from `cells` on to
    //           the first ones
    // Notes     Positions have an error below 2e-16 cells, regardless of the number of periods and cells. The same bits
    //           on every instruction set.
    void (*spread)(const SpreadSamples &samples, const SpreadShape &shape, const SpreadPhases &phases, size_t pairs,
                   double *const *grids) noexcept;
};
TOLIMAN_ISA_DECLARE(SpreadKernels, spread)

} // namespace toliman::kernels
