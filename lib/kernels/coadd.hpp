// Registration, test and sum of short frames of 16-bit counts: hundreds of thousands of them become one.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kCoaddLanes = 16; // numbers of a vector, on every instruction set

// Images of the light of all stars at one place and its derivatives by the place: photons = scale times the integers.
struct CoaddModel {
    const uint16_t *light;
    const int16_t *slope_x, *slope_y;
    size_t stride; // of the rows of all three; a row can be read up to the next multiple of kCoaddLanes
    float light_scale, slope_scale;
};

// How the counts of a pixel become photons, gain counts - offset, and their variance, spread photons + added. Arrays
// [rows][cols], or one number for all pixels if `uniform`. A pixel that is not used has `added` = kCoaddUnused.
constexpr float kCoaddUnused = 1e30f;
struct CoaddPixels {
    bool uniform;
    const float *gain, *offset, *spread, *added;
    float least;   // photons of which a variance is taken, at least
    float limit;   // photons at which a pixel saturates, times 1/spread
    uint16_t most; // counts at which it does, at least 1
    bool far;      // the light of no place is within 7 standard deviations of the limit
};

struct CoaddFrame {
    const uint16_t *counts;
    size_t stride, rows, cols;
};

// What a frame is compared with: flux light + x slope_x + y slope_y.
struct CoaddStep {
    float flux, x, y;
};

// The sums of accumulate(), over pixels and with weights w = 1/variance, r the residual, L, X, Y the three images.
enum CoaddSum : size_t { sum_ll, sum_lx, sum_ly, sum_xx, sum_xy, sum_yy, sum_lr, sum_xr, sum_yr, sum_rr, kCoaddSums };

struct CoaddKernels {
    // Given     rows start, start + step, ... of a frame, the model at the expected place, and `flux` as the expected
    //           one
    // Returned  sums[kCoaddSums]; weights are those of the expected light
    // Notes     products, and sums of up to 64 of them per lane (of one row, if that has more), are single precision,
    //           further sums double; the same bits on every instruction set
    void (*accumulate)(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, float flux,
                       size_t start, size_t step, double *sums) noexcept;

    // Given     a frame, the model and the fitted step
    // Returned  the number of pixels that are left out, and the first `capacity` of them in `found`, each row cols +
    //           col, in increasing order: x^2 > limit (1 + max(x, 0)/(3 sqrt(V))) with x the residual over its standard
    //           deviation sqrt(V), as of frame/bad_pixels.hpp; or saturated, or expected within 5 standard deviations
    //           of the limit
    // Notes     the same bits on every instruction set
    size_t (*test)(const CoaddFrame &frame, const CoaddModel &model, const CoaddPixels &pixels, const CoaddStep &step,
                   float limit, uint32_t *found, size_t capacity) noexcept;

    // Returned  sums[rows][cols]: plus the counts, modulo 2^32
    void (*add)(const CoaddFrame &frame, uint32_t *sums) noexcept;

    // Returned  the number of rows of which all counts are 0
    size_t (*zero_rows)(const CoaddFrame &frame) noexcept;
};
TOLIMAN_ISA_DECLARE(CoaddKernels, coadd)

} // namespace toliman::kernels
