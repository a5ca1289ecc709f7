// The stages of layouts `flight` and `core` (2x2 mean, kernels/conv.hpp) and of `paper` (2x2 maximum,
// kernels/same_conv.hpp).
//
// `paper` reproduces the architecture of the book chapter (README.md). `flight` is the default for its efficiency: with
// the same weights, a prototype fell from 0.984 to 0.124 when average pooling was replaced by max pooling. A mean is
// also linear, so that it merges with the convolution into one operator and the decoder needs no switches of a frame.
#include "cae/stage.hpp"

#include "kernels/elu.hpp"

namespace toliman::cae {

namespace {

class MeanStage final : public Stage {
  public:
    using Stage::Stage;
    float encoder_factor() const noexcept override { return 0.25f; }
    size_t packed() const noexcept override { return shape().packed(); }
    size_t dense() const noexcept override { return 0; }
    size_t switches() const noexcept override { return 0; }
    void pack_down(const float *kernel, float factor, float *packed) const noexcept override {
        kernels::conv_pack_down(shape(), kernel, factor, packed);
    }
    void pack_up(const float *kernel, float factor, float *packed) const noexcept override {
        kernels::conv_pack_up(shape(), kernel, factor, packed);
    }
    void unpack_gradient(const float *packed, float factor, float *kernel) const noexcept override {
        kernels::conv_unpack_gradient(shape(), packed, factor, kernel);
    }
    void encode(const float *fine, const float *packed, const float *bias, float *coarse,
                Switch *) const noexcept override {
        kernels::conv_kernels().down_elu(shape(), fine, packed, bias, coarse);
    }
    void down(const float *fine, const float *packed, const Switch *, float *, float *coarse) const noexcept override {
        kernels::conv_kernels().down(shape(), fine, packed, kZeroBias, coarse);
    }
    void up(const float *coarse, const float *packed, const float *bias, const Switch *, float *,
            float *fine) const noexcept override {
        kernels::conv_kernels().up(shape(), coarse, packed, bias != nullptr ? bias : kZeroBias, fine);
    }
    void gradient(const float *fine, const float *coarse, const Switch *, float *,
                  float *packed) const noexcept override {
        kernels::conv_kernels().weight_gradient(shape(), fine, coarse, packed);
    }
};

// `dense` has the fine image's size and the coarse image's channels: a convolution before pooling, or an un-pooled
// image.
class MaxStage final : public Stage {
  public:
    using Stage::Stage;
    float encoder_factor() const noexcept override { return 1; }
    size_t packed() const noexcept override { return encoder_shape().packed(); }
    size_t dense() const noexcept override {
        return (2 * shape().rows + 2) * (2 * shape().cols + 2) * shape().coarse_channels;
    }
    size_t switches() const noexcept override { return shape().rows * shape().cols * shape().coarse_channels; }
    void pack_down(const float *kernel, float, float *packed) const noexcept override {
        kernels::same_pack(encoder_shape(), kernel, packed);
    }
    void pack_up(const float *kernel, float, float *packed) const noexcept override {
        kernels::same_pack_adjoint(decoder_shape(), kernel, packed);
    }
    void unpack_gradient(const float *packed, float, float *kernel) const noexcept override {
        kernels::same_unpack_gradient(encoder_shape(), packed, kernel);
    }
    void encode(const float *fine, const float *packed, const float *bias, float *coarse,
                Switch *switches) const noexcept override {
        kernels::same_conv_kernels().same_max(encoder_shape(), fine, packed, bias, coarse, switches);
        kernels::elu_kernels().elu(coarse, shape().coarse());
    }
    void down(const float *fine, const float *packed, const Switch *switches, float *dense,
              float *coarse) const noexcept override {
        kernels::same_conv_kernels().same(encoder_shape(), fine, packed, nullptr, dense);
        kernels::same_conv_kernels().pick(encoder_shape(), dense, switches, coarse);
    }
    void up(const float *coarse, const float *packed, const float *bias, const Switch *switches, float *dense,
            float *fine) const noexcept override {
        kernels::same_conv_kernels().unpool(encoder_shape(), coarse, switches, dense);
        kernels::same_conv_kernels().same(decoder_shape(), dense, packed, bias, fine);
    }
    void gradient(const float *fine, const float *coarse, const Switch *switches, float *dense,
                  float *packed) const noexcept override {
        kernels::same_conv_kernels().unpool(encoder_shape(), coarse, switches, dense);
        kernels::same_conv_kernels().weight_gradient(encoder_shape(), fine, dense, packed);
    }

  private:
    kernels::SameShape encoder_shape() const noexcept {
        return {2 * shape().rows, 2 * shape().cols, shape().fine_channels, shape().coarse_channels};
    }
    kernels::SameShape decoder_shape() const noexcept {
        return {2 * shape().rows, 2 * shape().cols, shape().coarse_channels, shape().fine_channels};
    }
};

template <class Kind> struct Stages {
    explicit Stages(const Layout &layout)
        : stages{Kind(layout.shapes[0]), Kind(layout.shapes[1]), Kind(layout.shapes[2]), Kind(layout.shapes[3])} {}
    Kind stages[kStages];
};

} // namespace

const Stage &stage_of(const Layout &layout, size_t stage) noexcept {
    static const Stages<MeanStage> flight(kFlight), core(kCore);
    static const Stages<MaxStage> paper(kPaper);
    return layout.max_pool ? static_cast<const Stage &>(paper.stages[stage])
                           : (layout.side == kCore.side ? core : flight).stages[stage];
}

} // namespace toliman::cae
