// C interface of the convolution kernels; images are passed without their borders.
#include <algorithm>
#include <vector>

#include "isa_tables.hpp"
#include "kernels/conv.hpp"
#include "kernels/elu.hpp"
#include "kernels/same_conv.hpp"

using toliman::kernels::ConvShape;
using toliman::kernels::SameShape;
using Floats = std::vector<float>;

namespace {

Floats bordered(const float *image, size_t rows, size_t cols, size_t channels) {
    Floats out((rows + 2) * (cols + 2) * channels, 0.0f);
    for (size_t y = 0; image != nullptr && y < rows; y++)
        std::copy_n(image + y * cols * channels, cols * channels, &out[((y + 1) * (cols + 2) + 1) * channels]);
    return out;
}

void inside(const Floats &image, size_t rows, size_t cols, size_t channels, float *out) {
    for (size_t y = 0; y < rows; y++)
        std::copy_n(&image[((y + 1) * (cols + 2) + 1) * channels], cols * channels, out + y * cols * channels);
}

} // namespace

extern "C" void shim_conv_down(int isa, const size_t *dimensions, const float *image, const float *kernel, float factor,
                               const float *bias, float *out) {
    const ConvShape shape = {dimensions[0], dimensions[1], dimensions[2], dimensions[3]};
    Floats packed(shape.packed()), coarse(shape.coarse());
    toliman::kernels::conv_pack_down(shape, kernel, factor, packed.data());
    KERNELS(conv, isa).down(shape, bordered(image, 2 * shape.rows, 2 * shape.cols, shape.fine_channels).data(),
                            packed.data(), bias, coarse.data());
    inside(coarse, shape.rows, shape.cols, shape.coarse_channels, out);
}

// out: of down_elu; expected: elu of down.
extern "C" void shim_conv_down_elu(int isa, const size_t *dimensions, const float *image, const float *kernel,
                                   const float *bias, float *out, float *expected) {
    const ConvShape shape = {dimensions[0], dimensions[1], dimensions[2], dimensions[3]};
    Floats packed(shape.packed()), coarse(shape.coarse());
    toliman::kernels::conv_pack_down(shape, kernel, 0.25f, packed.data());
    const Floats fine = bordered(image, 2 * shape.rows, 2 * shape.cols, shape.fine_channels);
    KERNELS(conv, isa).down_elu(shape, fine.data(), packed.data(), bias, coarse.data());
    inside(coarse, shape.rows, shape.cols, shape.coarse_channels, out);
    KERNELS(conv, isa).down(shape, fine.data(), packed.data(), bias, coarse.data());
    inside(coarse, shape.rows, shape.cols, shape.coarse_channels, expected);
    KERNELS(elu, isa).elu(expected, shape.rows * shape.cols * shape.coarse_channels);
}

extern "C" void shim_conv_up(int isa, const size_t *dimensions, const float *image, const float *kernel, float factor,
                             const float *bias, float *out) {
    const ConvShape shape = {dimensions[0], dimensions[1], dimensions[2], dimensions[3]};
    Floats packed(shape.packed()), fine(shape.fine());
    toliman::kernels::conv_pack_up(shape, kernel, factor, packed.data());
    KERNELS(conv, isa).up(shape, bordered(image, shape.rows, shape.cols, shape.coarse_channels).data(), packed.data(),
                          bias, fine.data());
    inside(fine, 2 * shape.rows, 2 * shape.cols, shape.fine_channels, out);
}

extern "C" void shim_conv_gradient(int isa, const size_t *dimensions, const float *fine, const float *coarse,
                                   float factor, float *kernel) {
    const ConvShape shape = {dimensions[0], dimensions[1], dimensions[2], dimensions[3]};
    Floats packed(shape.packed());
    KERNELS(conv, isa).weight_gradient(
        shape, bordered(fine, 2 * shape.rows, 2 * shape.cols, shape.fine_channels).data(),
        bordered(coarse, shape.rows, shape.cols, shape.coarse_channels).data(), packed.data());
    toliman::kernels::conv_unpack_gradient(shape, packed.data(), factor, kernel);
}

// kernel: [channels][in_channels][3][3], or, if adjoint, [in_channels][channels][3][3].
extern "C" void shim_same(int isa, const size_t *d, const float *image, const float *kernel, int adjoint,
                          const float *bias, float *out) {
    const SameShape shape = {d[0], d[1], d[2], d[3]};
    Floats packed(shape.packed()), result = bordered(nullptr, d[0], d[1], d[3]);
    (adjoint != 0 ? toliman::kernels::same_pack_adjoint : toliman::kernels::same_pack)(shape, kernel, packed.data());
    KERNELS(same_conv, isa).same(shape, bordered(image, d[0], d[1], d[2]).data(), packed.data(), bias, result.data());
    inside(result, d[0], d[1], d[3], out);
}

extern "C" void shim_same_max(int isa, const size_t *d, const float *image, const float *kernel, const float *bias,
                              float *pooled, int32_t *switches) {
    const SameShape shape = {d[0], d[1], d[2], d[3]};
    Floats packed(shape.packed()), result = bordered(nullptr, d[0] / 2, d[1] / 2, d[3]);
    toliman::kernels::same_pack(shape, kernel, packed.data());
    KERNELS(same_conv, isa)
        .same_max(shape, bordered(image, d[0], d[1], d[2]).data(), packed.data(), bias, result.data(), switches);
    inside(result, d[0] / 2, d[1] / 2, d[3], pooled);
}

extern "C" void shim_same_gradient(int isa, const size_t *d, const float *in, const float *out, float *kernel) {
    const SameShape shape = {d[0], d[1], d[2], d[3]};
    Floats packed(shape.packed());
    KERNELS(same_conv, isa)
        .weight_gradient(shape, bordered(in, d[0], d[1], d[2]).data(), bordered(out, d[0], d[1], d[3]).data(),
                         packed.data());
    toliman::kernels::same_unpack_gradient(shape, packed.data(), kernel);
}

extern "C" void shim_unpool(int isa, const size_t *d, const float *pooled, const int32_t *switches, float *out) {
    const SameShape shape = {d[0], d[1], d[2], d[3]};
    Floats result = bordered(nullptr, d[0], d[1], d[3]);
    KERNELS(same_conv, isa).unpool(shape, bordered(pooled, d[0] / 2, d[1] / 2, d[3]).data(), switches, result.data());
    inside(result, d[0], d[1], d[3], out);
}

extern "C" void shim_pick(int isa, const size_t *d, const float *image, const int32_t *switches, float *pooled) {
    const SameShape shape = {d[0], d[1], d[2], d[3]};
    Floats result = bordered(nullptr, d[0] / 2, d[1] / 2, d[3]);
    KERNELS(same_conv, isa).pick(shape, bordered(image, d[0], d[1], d[3]).data(), switches, result.data());
    inside(result, d[0] / 2, d[1] / 2, d[3], pooled);
}
