// Packing of 3x3 kernels for kernels/same_conv.isa.cpp: transformed to 4x4 for Winograd's form, transposed to
// [tap][input channel][channel] otherwise. Done once per set of weights.
#include "kernels/same_conv.hpp"

namespace toliman::kernels {

namespace {

// Winograd's kernel transform G g G^T of 3x3 taps, G = (1 0 0; 1/2 1/2 1/2; 1/2 -1/2 1/2; 0 0 1).
void winograd_kernel(const float *taps, float *out) noexcept {
    float half[4][3];
    for (size_t x = 0; x < 3; x++) {
        const float a = taps[x], b = taps[3 + x], c = taps[6 + x];
        half[0][x] = a;
        half[1][x] = 0.5f * (a + b + c);
        half[2][x] = 0.5f * (a - b + c);
        half[3][x] = c;
    }
    for (size_t y = 0; y < 4; y++) {
        const float a = half[y][0], b = half[y][1], c = half[y][2];
        out[4 * y] = a;
        out[4 * y + 1] = 0.5f * (a + b + c);
        out[4 * y + 2] = 0.5f * (a - b + c);
        out[4 * y + 3] = c;
    }
}

// tap(c, k, i): tap i of the kernel from input channel c to channel k.
template <class Tap> void pack(const SameShape &shape, Tap tap, float *packed) noexcept {
    const size_t pairs = shape.in_channels * shape.channels;
    for (size_t c = 0; c < shape.in_channels; c++)
        for (size_t k = 0; k < shape.channels; k++) {
            float taps[16], transformed[16];
            for (size_t i = 0; i < 9; i++)
                taps[i] = tap(c, k, i);
            winograd_kernel(taps, transformed);
            for (size_t i = 0; i < (shape.winograd() ? 16 : 9); i++)
                packed[i * pairs + c * shape.channels + k] = shape.winograd() ? transformed[i] : taps[i];
        }
}

} // namespace

void same_pack(const SameShape &shape, const float *kernel, float *packed) noexcept {
    pack(
        shape, [&](size_t c, size_t k, size_t i) { return kernel[(k * shape.in_channels + c) * 9 + i]; }, packed);
}

void same_pack_adjoint(const SameShape &shape, const float *kernel, float *packed) noexcept {
    pack(
        shape, [&](size_t c, size_t k, size_t i) { return kernel[(c * shape.channels + k) * 9 + 8 - i]; }, packed);
}

void same_unpack_gradient(const SameShape &shape, const float *packed, float *kernel) noexcept {
    for (size_t k = 0; k < shape.channels; k++)
        for (size_t c = 0; c < shape.in_channels; c++)
            for (size_t tap = 0; tap < 9; tap++)
                *kernel++ = packed[(tap * shape.in_channels + c) * shape.channels + k];
}

} // namespace toliman::kernels
