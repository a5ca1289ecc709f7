// Method: reverse-mode differentiation (back-propagation), written out layer by layer from the decoder output to the
// first convolution. But for its ELU each stage is linear (for given switches), and `down` and `up` are each other's
// adjoint for equal kernel and switches (cae/stage.hpp), so that the backward pass reuses the forward operators:
//     d loss/d input  = adjoint operator applied to d loss/d output
//     d loss/d kernel = correlation of the stage's input with d loss/d output
// The derivative of ELU follows from its value y alone: 1 for y > 0, y + 1 otherwise. Activations before ELU need not
// be stored. Gradients of kernels are summed in packed order and unpacked once per batch. Tested against finite
// differences in long double (tests/kernel/test_backward.c).
#include "cae/backward.hpp"

#include <algorithm>

#include "kernels/elu.hpp"

namespace toliman::cae {

namespace {

void add_to(const Buffer<float> &values, Buffer<float> &sums) noexcept {
    for (size_t i = 0; i < values.size(); i++)
        sums[i] += values[i];
}

} // namespace

Operators::Operators(const Parameters &parameters)
    : encoder_down(pack_encoder(parameters)), decoder_up(pack_decoder(parameters)) {
    for (size_t s = 0; s < kStages; s++) {
        const Stage &stage = stage_of(*parameters.layout, s);
        encoder_up[s].resize(stage.packed());
        stage.pack_up(parameters[conv_weight(s)], stage.encoder_factor(), encoder_up[s].data());
        decoder_down[s].resize(stage.packed());
        stage.pack_down(parameters[deconv_weight(s)], 1.0f, decoder_down[s].data());
    }
}

Gradient::Gradient(const Layout &layout) : layout_(layout), sums_(layout) {
    for (size_t s = 0; s < kStages; s++)
        for (Packed *packed : {&encoder_, &decoder_, &one_})
            (*packed)[s].resize(stage_of(layout, s).packed());
}

void Gradient::add(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept {
    add_decoder(parameters, operators, pass);
    add_encoder(operators, pass);
}

// Propagates gradient[0], with respect to the decoder output, to gradient[kStages], with respect to the encoder's
// features.
void Gradient::add_decoder(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept {
    for (size_t s = 0; s < kStages; s++) {
        const Stage &stage = stage_of(layout_, s);
        const Switch *switches = pass.pooling.switches[s].data();
        float *dense = pass.pooling.dense[s].data();
        kernels::elu_kernels().sum_pixels(pass.gradient[s], layout_.shapes[s].fine(), layout_.shapes[s].fine_channels,
                                          sums_[deconv_bias(s)]);
        stage.gradient(pass.gradient[s], pass.decoder[s + 1], switches, dense, one_[s].data());
        add_to(one_[s], decoder_[s]);
        stage.down(pass.gradient[s], operators.decoder_down[s].data(), switches, dense, pass.gradient[s + 1]);
        kernels::elu_kernels().slope(pass.decoder[s + 1], layout_.shapes[s].coarse(), pass.gradient[s + 1]);
    }
    // The dense layers. The gradient with respect to the features replaces that with respect to the decoder's first
    // image.
    const size_t row = layout_.deep_side() * kDeepChannels;
    double by_latent = 0;
    for (size_t r = 0; r < layout_.deep_side(); r++) {
        const float *gradient = pass.gradient[kStages] + layout_.feature_at(r);
        const float *weight = parameters[kExpandWeight] + r * row;
        float *by_weight = sums_[kExpandWeight] + r * row, *by_bias = sums_[kExpandBias] + r * row;
        for (size_t i = 0; i < row; i++) {
            by_latent += static_cast<double>(gradient[i]) * static_cast<double>(weight[i]);
            by_weight[i] += gradient[i] * pass.latent;
            by_bias[i] += gradient[i];
        }
    }
    const auto slope = static_cast<float>(by_latent);
    sums_[kLatentBias][0] += slope;
    for (size_t r = 0; r < layout_.deep_side(); r++) {
        const size_t at = layout_.feature_at(r);
        const float *features = pass.encoder[kStages] + at, *weight = parameters[kLatentWeight] + r * row;
        float *gradient = pass.gradient[kStages] + at, *by_weight = sums_[kLatentWeight] + r * row;
        for (size_t i = 0; i < row; i++) {
            by_weight[i] += slope * features[i];
            gradient[i] = slope * weight[i];
        }
    }
}

void Gradient::add_encoder(const Operators &operators, Pass &pass) noexcept {
    for (size_t s = kStages; s-- > 0;) {
        const Stage &stage = stage_of(layout_, s);
        const Switch *switches = pass.pooling.switches[s].data();
        float *dense = pass.pooling.dense[s].data(), *gradient = pass.gradient[s + 1];
        kernels::elu_kernels().slope(pass.encoder[s + 1], layout_.shapes[s].coarse(), gradient);
        kernels::elu_kernels().sum_pixels(gradient, layout_.shapes[s].coarse(), layout_.shapes[s].coarse_channels,
                                          sums_[conv_bias(s)]);
        stage.gradient(pass.encoder[s], gradient, switches, dense, one_[s].data());
        add_to(one_[s], encoder_[s]);
        if (s > 0)
            stage.up(gradient, operators.encoder_up[s].data(), nullptr, switches, dense, pass.gradient[s]);
    }
}

void Gradient::add(const Gradient &other) noexcept {
    add_to(other.sums_.values, sums_.values);
    for (size_t s = 0; s < kStages; s++) {
        add_to(other.encoder_[s], encoder_[s]);
        add_to(other.decoder_[s], decoder_[s]);
    }
}

void Gradient::clear() noexcept {
    std::fill(sums_.values.begin(), sums_.values.end(), 0.0f);
    for (size_t s = 0; s < kStages; s++) {
        std::fill(encoder_[s].begin(), encoder_[s].end(), 0.0f);
        std::fill(decoder_[s].begin(), decoder_[s].end(), 0.0f);
    }
}

void Gradient::get(Parameters &out) const noexcept {
    out.values = sums_.values;
    for (size_t s = 0; s < kStages; s++) {
        const Stage &stage = stage_of(layout_, s);
        stage.unpack_gradient(encoder_[s].data(), stage.encoder_factor(), out[conv_weight(s)]);
        stage.unpack_gradient(decoder_[s].data(), 1.0f, out[deconv_weight(s)]);
    }
}

} // namespace toliman::cae
