#include "kernels/conv.hpp"

namespace toliman::kernels {

namespace {

// Element (u, v) of the 4x4 kernel: what of the 3x3 kernel meets the same fine pixel through the 2x2 mean.
float box(const float *kernel, size_t u, size_t v) noexcept {
    float sum = 0;
    for (size_t y = 0; y < 3; y++)
        for (size_t x = 0; x < 3; x++)
            if (u - y <= 1 && v - x <= 1)
                sum += kernel[3 * y + x];
    return sum;
}

} // namespace

void conv_pack_down(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept {
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    for (size_t u = 0; u < 4; u++)
        for (size_t v = 0; v < 4; v++)
            for (size_t c = 0; c < fine; c++)
                for (size_t k = 0; k < coarse; k++)
                    *packed++ = factor * box(kernel + (k * fine + c) * 9, u, v);
}

// Fine pixel (2 Y + a, 2 X + b) sees the coarse pixels (Y - 1 + a + i, X - 1 + b + j) through u = 3 - a - 2 i, v alike.
void conv_pack_up(const ConvShape &shape, const float *kernel, float factor, float *packed) noexcept {
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    for (size_t phase = 0; phase < 4; phase++)
        for (size_t tap = 0; tap < 4; tap++)
            for (size_t k = 0; k < coarse; k++)
                for (size_t c = 0; c < fine; c++)
                    *packed++ = factor * box(kernel + (k * fine + c) * 9, 3 - phase / 2 - 2 * (tap / 2),
                                             3 - phase % 2 - 2 * (tap % 2));
}

void conv_unpack_gradient(const ConvShape &shape, const float *packed, float factor, float *kernel) noexcept {
    const size_t fine = shape.fine_channels, coarse = shape.coarse_channels;
    for (size_t k = 0; k < coarse; k++)
        for (size_t c = 0; c < fine; c++)
            for (size_t y = 0; y < 3; y++)
                for (size_t x = 0; x < 3; x++) {
                    float sum = 0;
                    for (size_t corner = 0; corner < 4; corner++) {
                        const size_t u = y + corner / 2, v = x + corner % 2;
                        sum += packed[((4 * u + v) * fine + c) * coarse + k];
                    }
                    *kernel++ = factor * sum;
                }
}

} // namespace toliman::kernels
