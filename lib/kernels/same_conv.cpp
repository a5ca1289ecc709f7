#include "kernels/same_conv.hpp"

namespace toliman::kernels {

void same_pack(const SameShape &shape, const float *kernel, float *packed) noexcept {
    for (size_t tap = 0; tap < 9; tap++)
        for (size_t c = 0; c < shape.in_channels; c++)
            for (size_t k = 0; k < shape.channels; k++)
                *packed++ = kernel[(k * shape.in_channels + c) * 9 + tap];
}

void same_pack_adjoint(const SameShape &shape, const float *kernel, float *packed) noexcept {
    for (size_t tap = 0; tap < 9; tap++)
        for (size_t c = 0; c < shape.in_channels; c++)
            for (size_t k = 0; k < shape.channels; k++)
                *packed++ = kernel[(c * shape.channels + k) * 9 + 8 - tap];
}

void same_unpack_gradient(const SameShape &shape, const float *packed, float *kernel) noexcept {
    for (size_t k = 0; k < shape.channels; k++)
        for (size_t c = 0; c < shape.in_channels; c++)
            for (size_t tap = 0; tap < 9; tap++)
                *kernel++ = packed[(tap * shape.in_channels + c) * shape.channels + k];
}

} // namespace toliman::kernels
