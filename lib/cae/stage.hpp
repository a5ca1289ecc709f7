// One stage of a layout between a fine image and a coarse one of half its side, as operations on float32 images with a
// border of zeros (kernels/conv.hpp). `down` and `up` are linear and, with the same kernel, factor and switches, each
// other's adjoint; so they serve encoder and decoder, forwards and backwards.
#pragma once
#include <cstddef>

#include "cae/layout.hpp"
#include "kernels/same_conv.hpp"

namespace toliman::cae {

using kernels::Switch;

class Stage {
  public:
    explicit constexpr Stage(const kernels::ConvShape &shape) noexcept : shape_(shape) {}
    Stage(const Stage &) = delete;
    Stage &operator=(const Stage &) = delete;
    virtual ~Stage() = default;

    const kernels::ConvShape &shape() const noexcept { return shape_; }

    // Of the encoder's kernel: 1/4 where 2x2 sums stand for means.
    virtual float encoder_factor() const noexcept = 0;
    // Floats of a packed kernel; of working memory with a border that must be zero; number of switches.
    virtual size_t packed() const noexcept = 0;
    virtual size_t dense() const noexcept = 0;
    virtual size_t switches() const noexcept = 0;

    // kernel [coarse channels][fine channels][3][3]
    virtual void pack_down(const float *kernel, float factor, float *packed) const noexcept = 0;
    virtual void pack_up(const float *kernel, float factor, float *packed) const noexcept = 0;
    virtual void unpack_gradient(const float *packed, float factor, float *kernel) const noexcept = 0;

    // Coarse image of the encoder before ELU; sets the switches, where there are any and they are not NULL.
    virtual void encode(const float *fine, const float *packed, const float *bias, float *coarse,
                        Switch *switches) const noexcept = 0;
    virtual void down(const float *fine, const float *packed, const Switch *switches, float *dense,
                      float *coarse) const noexcept = 0;
    virtual void up(const float *coarse, const float *packed, const float *bias, const Switch *switches, float *dense,
                    float *fine) const noexcept = 0;
    // Of the packed kernel, from two images of which one is a gradient.
    virtual void gradient(const float *fine, const float *coarse, const Switch *switches, float *dense,
                          float *packed) const noexcept = 0;

  private:
    kernels::ConvShape shape_;
};

const Stage &stage_of(const Layout &layout, size_t stage) noexcept;

} // namespace toliman::cae
