// Convolutions of layout `paper`: 3x3 'same' convolution at every pixel, 2x2 maximum pooling that records its switches,
// and un-pooling with them.
//
// The adjoint of a convolution is the convolution with the kernel rotated by 180 degrees and its channels exchanged.
// One kernel therefore serves the forward and backward passes of encoder and decoder.
//
// Images are float32, [row][col][channel], with a border of one zero pixel all around, as in kernels/conv.hpp.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct SameShape {
    size_t rows, cols;  // size of both images; even, cols a multiple of 16
    size_t in_channels; // 1, 8, 16, 32 or 64
    size_t channels;    // channels of the result, likewise; one of the two is above 1
    constexpr bool winograd() const noexcept { return in_channels > 1 && channels > 1; }
    constexpr size_t packed() const noexcept { return (winograd() ? 16 : 9) * in_channels * channels; }
};

// Position of a maximum in its 2x2 block: 0 to 3, row by row.
using Switch = int32_t;

struct SameConvKernels {
    // Given     in, bordered; packed weights; bias [channels], or NULL for zeros
    // Returned  the interior of out = bias + convolution; its border is unchanged
    void (*same)(const SameShape &shape, const float *in, const float *weights, const float *bias, float *out) noexcept;

    // Given     in, weights, bias as for same; channels a multiple of 8
    // Returned  the interior of pooled, bordered, rows/2 x cols/2: bias + maximum of each 2x2 block of the convolution;
    //           switches [rows/2][cols/2][channels], unless NULL: the position of the first maximum
    void (*same_max)(const SameShape &shape, const float *in, const float *weights, const float *bias, float *pooled,
                     Switch *switches) noexcept;

    // Given     in and out, bordered, one with activations and the other with a gradient
    // Returned  gradient with respect to the weights, [9][in_channels][channels]
    // Notes     channels is a multiple of 8
    void (*weight_gradient)(const SameShape &shape, const float *in, const float *out, float *packed) noexcept;

    // Given     pooled, bordered, rows/2 x cols/2; switches; shape's rows, cols and channels
    // Returned  the interior of out: each value at the position of its switch, 0 elsewhere
    void (*unpool)(const SameShape &shape, const float *pooled, const Switch *switches, float *out) noexcept;

    // Given     image, bordered; switches
    // Returned  the interior of pooled: the image's values at the positions of the switches; the adjoint of unpool
    void (*pick)(const SameShape &shape, const float *image, const Switch *switches, float *pooled) noexcept;

    // Notes     The order of sums is fixed, as in kernels/conv.hpp. Error of Winograd's form: about 2e-7 of the sum of
    //           absolute products times the root of their number. Values that are equal in exact arithmetic may differ
    //           by that, so that the switch of equal maxima is not defined.
    // Reference Lavin and Gray (2016), CVPR, section 4.1
};
TOLIMAN_ISA_DECLARE(SameConvKernels, same_conv)

// Given     kernel [outer][inner][3][3]. same_pack: outer = channels, inner = in_channels. same_pack_adjoint: outer =
//           in_channels, inner = channels, and the taps are rotated by 180 degrees
// Returned  packed [packed()], in the order in which the kernels above read it
void same_pack(const SameShape &shape, const float *kernel, float *packed) noexcept;
void same_pack_adjoint(const SameShape &shape, const float *kernel, float *packed) noexcept;

// Given     packed gradient from weight_gradient: [9][in_channels][channels]
// Returned  gradient with respect to the kernel given to same_pack
void same_unpack_gradient(const SameShape &shape, const float *packed, float *kernel) noexcept;

} // namespace toliman::kernels
