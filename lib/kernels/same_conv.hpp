// The convolutions of layout `paper`: 3x3 'same' convolution at every pixel, 2x2 maximum pooling that records its
// switches, and un-pooling with them. The adjoint of a convolution is the convolution with the kernel turned by half a
// turn and its channels exchanged, so one kernel serves the forward and backward passes of encoder and decoder.
//
// Between images of several channels, 2x2 pixels of the result are made at once as Winograd's F(2x2, 3x3): 16 products
// a pair of channels instead of 36.
//
// Images are float32, [row][col][channel], with a border of one zero pixel all around, as in kernels/conv.hpp.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/isa.hpp"

namespace toliman::kernels {

struct SameShape {
    size_t rows, cols;  // of both images; even, cols a multiple of 16
    size_t in_channels; // 1, 8, 16, 32 or 64
    size_t channels;    // of the result, likewise; one of the two is above 1
    constexpr bool winograd() const noexcept { return in_channels > 1 && channels > 1; }
    constexpr size_t packed() const noexcept { return (winograd() ? 16 : 9) * in_channels * channels; }
};

// Which pixel of its 2x2 a maximum came from: 0 to 3, row by row.
using Switch = int32_t;

struct SameConvKernels {
    // Given     in, bordered; weights packed; bias [channels], or NULL for zeros
    // Returned  the inside of out = bias + convolution; its border is left alone
    void (*same)(const SameShape &shape, const float *in, const float *weights, const float *bias, float *out) noexcept;

    // Given     in, weights, bias as of same; channels a multiple of 8
    // Returned  the inside of pooled, bordered, rows/2 x cols/2: bias + largest of each 2x2 of the convolution;
    //           switches [rows/2][cols/2][channels], where not NULL: the first that is as large
    void (*same_max)(const SameShape &shape, const float *in, const float *weights, const float *bias, float *pooled,
                     Switch *switches) noexcept;

    // Given     in and out, one of them a gradient; bordered
    // Returned  gradient of the weights, [9][in_channels][channels]
    // Notes     channels is a multiple of 8
    void (*weight_gradient)(const SameShape &shape, const float *in, const float *out, float *packed) noexcept;

    // Given     pooled, bordered, rows/2 x cols/2; switches; shape's rows, cols and channels
    // Returned  the inside of out: each value where its switch says, 0 elsewhere
    void (*unpool)(const SameShape &shape, const float *pooled, const Switch *switches, float *out) noexcept;

    // Given     image, bordered; switches
    // Returned  the inside of pooled: the image's values where the switches say; the adjoint of unpool
    void (*pick)(const SameShape &shape, const float *image, const Switch *switches, float *pooled) noexcept;

    // Notes     sums run in a fixed order, as in kernels/conv.hpp. Winograd's form rounds to about 2e-7 of the sum of
    //           the absolute products times their number's root; equal values by the definition may differ by that.
    // Reference Lavin and Gray (2016), section 4.1
};
TOLIMAN_ISA_DECLARE(SameConvKernels, same_conv)

// Given     kernel [outer][inner][3][3]; in forward packing outer is channels and inner in_channels, in adjoint packing
//           the other way round, and taps are turned
// Returned  packed [packed()], as the kernels above read it
void same_pack(const SameShape &shape, const float *kernel, float *packed) noexcept;
void same_pack_adjoint(const SameShape &shape, const float *kernel, float *packed) noexcept;

// Given     gradient from weight_gradient: [9][in_channels][channels]
// Returned  gradient of the kernel that same_pack packs
void same_unpack_gradient(const SameShape &shape, const float *packed, float *kernel) noexcept;

} // namespace toliman::kernels
