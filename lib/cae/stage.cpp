#include "cae/stage.hpp"

namespace toliman::cae {

namespace {

constexpr float kZeroBias[kDeepChannels] = {}; // the linear operations have none

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
        kernels::conv_kernels().down(shape(), fine, packed, bias, coarse);
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

// `dense` is the fine image's size with the coarse one's channels: a convolution before pooling, or un-pooled.
class MaxStage final : public Stage {
  public:
    using Stage::Stage;
    float encoder_factor() const noexcept override { return 1; }
    size_t packed() const noexcept override { return inwards().packed(); }
    size_t dense() const noexcept override {
        return (2 * shape().rows + 2) * (2 * shape().cols + 2) * shape().coarse_channels;
    }
    size_t switches() const noexcept override { return shape().rows * shape().cols * shape().coarse_channels; }
    void pack_down(const float *kernel, float, float *packed) const noexcept override {
        kernels::same_pack(inwards(), kernel, packed);
    }
    void pack_up(const float *kernel, float, float *packed) const noexcept override {
        kernels::same_pack_adjoint(outwards(), kernel, packed);
    }
    void unpack_gradient(const float *packed, float, float *kernel) const noexcept override {
        kernels::same_unpack_gradient(inwards(), packed, kernel);
    }
    void encode(const float *fine, const float *packed, const float *bias, float *coarse,
                Switch *switches) const noexcept override {
        kernels::same_conv_kernels().same_max(inwards(), fine, packed, bias, coarse, switches);
    }
    void down(const float *fine, const float *packed, const Switch *switches, float *dense,
              float *coarse) const noexcept override {
        kernels::same_conv_kernels().same(inwards(), fine, packed, nullptr, dense);
        kernels::same_conv_kernels().pick(inwards(), dense, switches, coarse);
    }
    void up(const float *coarse, const float *packed, const float *bias, const Switch *switches, float *dense,
            float *fine) const noexcept override {
        kernels::same_conv_kernels().unpool(inwards(), coarse, switches, dense);
        kernels::same_conv_kernels().same(outwards(), dense, packed, bias, fine);
    }
    void gradient(const float *fine, const float *coarse, const Switch *switches, float *dense,
                  float *packed) const noexcept override {
        kernels::same_conv_kernels().unpool(inwards(), coarse, switches, dense);
        kernels::same_conv_kernels().weight_gradient(inwards(), fine, dense, packed);
    }

  private:
    kernels::SameShape inwards() const noexcept {
        return {2 * shape().rows, 2 * shape().cols, shape().fine_channels, shape().coarse_channels};
    }
    kernels::SameShape outwards() const noexcept {
        return {2 * shape().rows, 2 * shape().cols, shape().coarse_channels, shape().fine_channels};
    }
};

} // namespace

const Stage &stage_of(const Layout &layout, size_t stage) noexcept {
    static const MeanStage mean[kStages] = {MeanStage(kShapes[0]), MeanStage(kShapes[1]), MeanStage(kShapes[2]),
                                            MeanStage(kShapes[3])};
    static const MaxStage max[kStages] = {MaxStage(kShapes[0]), MaxStage(kShapes[1]), MaxStage(kShapes[2]),
                                          MaxStage(kShapes[3])};
    return layout.max_pool ? static_cast<const Stage &>(max[stage]) : mean[stage];
}

} // namespace toliman::cae
