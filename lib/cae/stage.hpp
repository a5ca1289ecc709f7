// One stage of a layout: operators between a fine image and a coarse image of half its side. Images are float32 with a
// border of zeros (kernels/conv.hpp). `down` and `up` are linear and, for equal kernel, factor and switches, each
// other's adjoint. Encoder and decoder therefore use both, one in the forward pass and the other in the backward pass.
#pragma once
#include <cstddef>

#include "cae/layout.hpp"
#include "kernels/same_conv.hpp"

namespace toliman::cae {

using kernels::Switch;

constexpr float kZeroBias[kDeepChannels] = {}; // of operators without bias

class Stage {
  public:
    explicit constexpr Stage(const kernels::ConvShape &shape) noexcept : shape_(shape) {}
    Stage(const Stage &) = delete;
    Stage &operator=(const Stage &) = delete;
    virtual ~Stage() = default;

    const kernels::ConvShape &shape() const noexcept { return shape_; }

    // Factor of the encoder's kernel: 1/4 where the operator takes 2x2 sums and the layout 2x2 means.
    virtual float encoder_factor() const noexcept = 0;
    // Sizes: floats of a packed kernel; floats of the scratch image `dense`, whose border must be 0; switches.
    virtual size_t packed() const noexcept = 0;
    virtual size_t dense() const noexcept = 0;
    virtual size_t switches() const noexcept = 0;

    // Convert between kernel [coarse channels][fine channels][3][3] and the packed order.
    virtual void pack_down(const float *kernel, float factor, float *packed) const noexcept = 0;
    virtual void pack_up(const float *kernel, float factor, float *packed) const noexcept = 0;
    virtual void unpack_gradient(const float *packed, float factor, float *kernel) const noexcept = 0;

    // Coarse image of the encoder after ELU; stores the pooling switches if the stage has any and switches is not
    // NULL.
    virtual void encode(const float *fine, const float *packed, const float *bias, float *coarse,
                        Switch *switches) const noexcept = 0;
    // Linear operator from fine to coarse, without bias.
    virtual void down(const float *fine, const float *packed, const Switch *switches, float *dense,
                      float *coarse) const noexcept = 0;
    // Adjoint of down, plus bias; NULL: no bias.
    virtual void up(const float *coarse, const float *packed, const float *bias, const Switch *switches, float *dense,
                    float *fine) const noexcept = 0;
    // Gradient of the packed kernel; one of the two images holds activations, the other a gradient.
    virtual void gradient(const float *fine, const float *coarse, const Switch *switches, float *dense,
                          float *packed) const noexcept = 0;

  private:
    kernels::ConvShape shape_;
};

// The stage, counted from 0 at the input; static storage.
const Stage &stage_of(const Layout &layout, size_t stage) noexcept;

} // namespace toliman::cae
