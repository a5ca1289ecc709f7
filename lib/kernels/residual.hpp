// Whitened and projected residuals of counts: the input of the network and of the template. Double precision.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kMaxPlanes = 32;  // of a projection
constexpr size_t kMaxTogether = 8; // frames that are projected together
constexpr size_t kMaxColumns = 256;

// Planes of a residual in rows; cols a multiple of 16 and at most kMaxColumns, planes at most kMaxPlanes.
struct ProjectedRows {
    size_t rows, cols, planes;
    const double *reference, *inverse_sigma; // [rows][cols]
    const float *basis; // [rows][planes][cols], orthonormal planes; a row of all planes is contiguous
    double scale;
};

struct ResidualKernels {
    // Given     counts, reference, inverse_sigma [count]
    // Returned  residual [count] = (counts - reference) inverse_sigma; true if all counts are finite
    bool (*residual)(const double *counts, const double *reference, const double *inverse_sigma, size_t count,
                     double *residual) noexcept;

    // The same times scale, rounded to float32 in the last step: the bits of `residual`, scaled and rounded.
    bool (*scaled_residual)(const double *counts, const double *reference, const double *inverse_sigma, double scale,
                            size_t count, float *residual) noexcept;

    // Given     basis [planes][count], orthonormal; vector [count]; count a multiple of 16; planes at most kMaxPlanes
    // Returned  vector minus its components along the basis
    // Notes     Uncompensated sums in 16 parts. Error of a component: at most count/16 rounding errors of the sum of
    //           absolute products, 5e-13 of it for a 256x256 frame. kernels/project.hpp has the compensated form.
    //           The same bits on every instruction set.
    void (*project_out)(const double *basis, size_t planes, size_t count, double *vector) noexcept;

    // Projection of frames, at most kMaxTogether, which read the planes once for all.
    // Given     counts[f] [rows][counts_stride]
    // Returned  vectors[f] [rows][cols]: `residual` of the counts, rounded to float32; components[f] [planes] of
    //           vectors[f] along the basis; true if all counts are finite
    // Notes     Rounding of the residual is relative to itself. That of a component leaves 6e-8 of it in the
    //           projected vector, along the basis. Sums in double in 16 parts; the same bits on every instruction set
    //           and for any number of frames.
    bool (*components)(const ProjectedRows &rows, size_t frames, const double *const *counts, size_t counts_stride,
                       float *const *vectors, float *const *components) noexcept;

    // Given     r, a row of the vectors, and their components
    // Returned  the row of vectors[f] minus its components along the basis, and out[f] [cols], the same times scale:
    //           computed in double and rounded to float32
    void (*project_row)(const ProjectedRows &rows, size_t frames, const float *const *components, size_t r,
                        float *const *vectors, float *const *out) noexcept;

    // Given     a, b [count]; count a multiple of 16
    // Returned  sum a_i b_i, as the same sums in 16 parts
    double (*inner)(const double *a, const double *b, size_t count) noexcept;

    // The same of float32 numbers, whose products are exact, in eight parts. count a multiple of 8
    double (*inner_float)(const float *a, const float *b, size_t count) noexcept;

    // Given     residual [count], whitened; tail [count], as frame/bad_pixels.hpp defines it
    // Returned  *most: the largest |residual|, and *excess: the largest residual (residual - tail), tail only where
    //           residual > 0; both at least their values before the call
    void (*largest)(const double *residual, const double *tail, size_t count, double *most, double *excess) noexcept;

    // Returned  the largest |residual|, and at least most; 0 <= most
    double (*magnitude)(const double *residual, size_t count, double most) noexcept;
    float (*magnitude_float)(const float *residual, size_t count, float most) noexcept;

    // As largest(), of residual - component target, in float32. count a multiple of 16
    void (*largest_float)(const float *residual, float component, const float *target, const float *tail, size_t count,
                          float *most, float *excess) noexcept;
};
TOLIMAN_ISA_DECLARE(ResidualKernels, residual)

} // namespace toliman::kernels
