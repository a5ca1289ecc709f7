// The convolutions of layout `flight`. Nearest up-sampling by 2 followed by a 3x3 transposed convolution is, but for a
// factor, the adjoint of a 3x3 convolution followed by a 2x2 mean. So one pair of kernels, down and up, is the
// encoder's forward and the decoder's backward pass and the other way round, and one kernel gives the weights' gradient
// of both. The mean is taken first: 2x2 sums of all pixels, then the convolution at every second one: 9 products a
// weight and coarse pixel, where convolution and mean take 36 and a 4x4 convolution of stride 2 takes 16.
//
// Images are float32, [row][col][channel], with a border of one zero pixel all around: (rows + 2)(cols + 2) channels.
// A stage joins a fine image of 2 rows x 2 cols pixels with a coarse one of rows x cols.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct ConvShape {
    size_t rows, cols;      // of the coarse image; cols at most 128, (2 cols + 1) fine_channels at most 1088
    size_t fine_channels;   // 1 or a multiple of 8
    size_t coarse_channels; // a multiple of 8
    constexpr size_t packed() const noexcept { return (fine_channels == 1 ? 16 : 9) * fine_channels * coarse_channels; }
    constexpr size_t fine() const noexcept { return (2 * rows + 2) * (2 * cols + 2) * fine_channels; }
    constexpr size_t coarse() const noexcept { return (rows + 2) * (cols + 2) * coarse_channels; }
};

struct ConvKernels {
    // Given     fine, bordered; weights packed by conv_pack_down; bias [coarse_channels]
    // Returned  the inside of coarse = bias + convolution of 2x2 sums; its border is left alone
    void (*down)(const ConvShape &shape, const float *fine, const float *weights, const float *bias,
                 float *coarse) noexcept;

    // Given     coarse, bordered; weights packed by conv_pack_up; bias [fine_channels]
    // Returned  the inside of fine = bias + the adjoint of down; its border is left alone or set to 0
    void (*up)(const ConvShape &shape, const float *coarse, const float *weights, const float *bias,
               float *fine) noexcept;

    // Given     the two images of a stage, one of them a gradient; bordered
    // Returned  gradient of the weights, in the order of conv_pack_down
    void (*weight_gradient)(const ConvShape &shape, const float *fine, const float *coarse, float *packed) noexcept;

    // Notes     every sum runs in a fixed order that no vector width enters: the same bits on every instruction set
    //           with fused multiply-add. Relative rounding below 1e-6 of the sum of the absolute products.
};
TOLIMAN_ISA_DECLARE(ConvKernels, conv)

// Given     kernel [coarse_channels][fine_channels][3][3], in the order of a framework's convolution and of its
//           transposed convolution alike; factor, 1/4 for a mean, 1 for plain up-sampling
// Returned  packed [packed()]: factor times the kernel, in the order in which the kernel above reads it
void conv_pack_down(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept;
void conv_pack_up(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept;

// Given     packed gradient from weight_gradient; factor as in packing
// Returned  gradient of the 3x3 kernel [coarse_channels][fine_channels][3][3]
void conv_unpack_gradient(const ConvShape &shape, const float *packed, float factor, float *kernel) noexcept;

} // namespace toliman::kernels
