// Whitened and projected residuals of counts: the input of the network and of the template. Double precision.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kMaxPlanes = 32; // of a projection

// Planes of a residual in rows; cols a multiple of 16, planes at most kMaxPlanes.
struct ProjectedRows {
    size_t rows, cols, planes;
    const double *reference, *inverse_sigma; // [rows][cols]
    const float *basis;                      // [planes][rows][cols], orthonormal
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

    // Given     counts [rows][counts_stride]
    // Returned  vector [rows][cols]: `residual` of the counts, then project_out; out [rows][out_stride] = scale vector,
    //           rounded to float32; true if all counts are finite
    // Notes     The same bits as these steps one after the other. A row is processed while it is in cache: vector is
    //           written twice and read once.
    bool (*project_rows)(const ProjectedRows &rows, const double *counts, size_t counts_stride, double *vector,
                         float *out, size_t out_stride) noexcept;

    // Given     a, b [count]; count a multiple of 16
    // Returned  sum a_i b_i, as the same sums in 16 parts
    double (*inner)(const double *a, const double *b, size_t count) noexcept;
};
TOLIMAN_ISA_DECLARE(ResidualKernels, residual)

} // namespace toliman::kernels
