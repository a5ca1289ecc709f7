// Packing of the 3x3 kernels into the order in which kernels/conv.isa.cpp reads them, so that its inner loops load
// consecutive floats. Done once per set of weights.
#include "kernels/conv.hpp"

namespace toliman::kernels {

namespace {

// Element (u, v) of the 4x4 kernel that equals the 3x3 kernel followed by a 2x2 sum: the sum of up to four taps.
float box(const float *kernel, size_t u, size_t v) noexcept {
    float sum = 0;
    for (size_t y = 0; y < 3; y++)
        for (size_t x = 0; x < 3; x++)
            if (u - y <= 1 && v - x <= 1)
                sum += kernel[3 * y + x];
    return sum;
}

void pack_patches(size_t coarse, const float *kernel, float factor, float *packed) noexcept {
    for (size_t k = 0; k < coarse; k++)
        for (size_t i = 0; i < 16; i++)
            *packed++ = factor * box(kernel + 9 * k, 2 * (i / 4 % 2) + i / 2 % 2, 2 * (i / 8) + i % 2);
}

} // namespace

void conv_pack_down(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept {
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    for (size_t tap = 0; tap < 9; tap++)
        for (size_t c = 0; c < fine; c++)
            for (size_t k = 0; k < coarse; k++)
                *packed++ = factor * kernel[(k * fine + c) * 9 + tap];
}

// Taps by output phase: even rows and columns of the result need the kernel's middle tap only; odd ones need the last
// tap, then the first.
void conv_pack_up(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept {
    constexpr size_t order[9] = {4, 5, 3, 7, 1, 8, 6, 2, 0};
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    if (fine == 1)
        return pack_patches(coarse, kernel, factor, packed);
    for (const size_t tap : order)
        for (size_t k = 0; k < coarse; k++)
            for (size_t c = 0; c < fine; c++)
                *packed++ = factor * kernel[(k * fine + c) * 9 + tap];
}

void conv_unpack_gradient(const ConvShape &shape, const float *packed, float factor, float *kernel) noexcept {
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    for (size_t k = 0; k < coarse; k++)
        for (size_t c = 0; c < fine; c++)
            for (size_t tap = 0; tap < 9; tap++)
                *kernel++ = factor * packed[(tap * fine + c) * coarse + k];
}

} // namespace toliman::kernels
