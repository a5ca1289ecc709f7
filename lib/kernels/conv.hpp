// Convolutions of layout `flight`: 3x3 convolution with 2x2 mean, and its adjoint.
//
// Nearest up-sampling by 2 followed by a 3x3 transposed convolution is, up to a factor, the adjoint of a 3x3
// convolution followed by a 2x2 mean. The kernel `down` therefore serves the encoder's forward and the decoder's
// backward pass, `up` the opposite ones, and one kernel computes the weight gradient of both.
//
// Images are float32, [row][col][channel], with a border of one zero pixel all around: (rows + 2)(cols + 2) channels
// floats. A stage connects a fine image of 2 rows x 2 cols pixels with a coarse image of rows x cols.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct ConvShape {
    size_t rows, cols;      // size of the coarse image; cols at most 128, (2 cols + 1) fine_channels at most kBoxFloats
    size_t fine_channels;   // 1 or a multiple of 8
    size_t coarse_channels; // a multiple of 8
    constexpr size_t packed() const noexcept { return (fine_channels == 1 ? 16 : 9) * fine_channels * coarse_channels; }
    constexpr size_t fine() const noexcept { return (2 * rows + 2) * (2 * cols + 2) * fine_channels; }
    constexpr size_t coarse() const noexcept { return (rows + 2) * (cols + 2) * coarse_channels; }
};

constexpr size_t kBoxFloats = 1088; // of a row of box sums: 257 x 1, 129 x 8, 65 x 16 or 33 x 32, rounded up

struct ConvKernels {
    // Given     fine, bordered; weights packed by conv_pack_down; bias [coarse_channels]
    // Returned  the interior of coarse = bias + convolution of 2x2 sums; its border is unchanged
    void (*down)(const ConvShape &shape, const float *fine, const float *weights, const float *bias,
                 float *coarse) noexcept;

    // The same, followed by ELU (kernels/elu.hpp) row by row while a row is in cache: the bits of `down`, then `elu`.
    void (*down_elu)(const ConvShape &shape, const float *fine, const float *weights, const float *bias,
                     float *coarse) noexcept;

    // down_elu of an image that arrives row by row.
    // Given     upper, lower: bordered rows i and i + 1 of the fine image
    // Returned  boxes [kBoxFloats]: row i of the sums of 2x2 pixels, in the order in which down_row reads them
    void (*box_row)(const ConvShape &shape, const float *upper, const float *lower, float *boxes) noexcept;

    // Given     boxes: rows 2 y, 2 y + 1 and 2 y + 2 of the box sums; weights, bias as for down
    // Returned  coarse [cols][coarse_channels]: row y of down_elu, without border
    void (*down_row)(const ConvShape &shape, const float *const boxes[3], const float *weights, const float *bias,
                     float *coarse) noexcept;

    // Given     coarse, bordered; weights packed by conv_pack_up; bias [fine_channels]
    // Returned  the interior of fine = bias + the adjoint of down; its border is unchanged or set to 0
    void (*up)(const ConvShape &shape, const float *coarse, const float *weights, const float *bias,
               float *fine) noexcept;

    // Given     the two bordered images of a stage, one with activations and the other with a gradient
    // Returned  gradient with respect to the weights, in the order of conv_pack_down
    void (*weight_gradient)(const ConvShape &shape, const float *fine, const float *coarse, float *packed) noexcept;

    // Notes     The order of every sum is fixed and independent of the vector width: the same bits on every instruction
    //           set with fused multiply-add. Rounding error below 1e-6 of the sum of absolute products.
};
TOLIMAN_ISA_DECLARE(ConvKernels, conv)

// Given     kernel [coarse_channels][fine_channels][3][3], the order of both convolution and transposed convolution in
//           PyTorch; factor, 1/4 for a 2x2 mean, 1 for nearest up-sampling
// Returned  packed [packed()]: factor times the kernel, in the order in which down or up reads it
void conv_pack_down(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept;
void conv_pack_up(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept;

// Given     packed gradient from weight_gradient; factor as in packing
// Returned  gradient with respect to the 3x3 kernel [coarse_channels][fine_channels][3][3]
void conv_unpack_gradient(const ConvShape &shape, const float *packed, float factor, float *kernel) noexcept;

} // namespace toliman::kernels
