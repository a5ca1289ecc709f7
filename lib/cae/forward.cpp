// Method: plain feed-forward evaluation. With s = 0 ... 3,
//     encoder   x_(s+1) = ELU(down_s(x_s) + b_s),      latent = <w, x_4> + b
//     decoder   y_4 = ELU(v latent + c),               y_s = ELU(up_s(y_(s+1)) + d_s), no ELU for s = 0
// Images are float32 with a border of one zero pixel, so that convolutions need no special case at the edge. The 2x2
// mean or maximum precedes the bias and the ELU. With a mean, it and the convolution then merge into one linear
// operator, and ELU runs on a quarter of the pixels; a prototype with the ELU first had the same efficiency within its
// statistical error (0.997 against 0.992 +- 3.5 %). For `paper` the order makes no difference: a maximum commutes with
// a constant and with a monotonic function. The latent's inner product of 16384 terms (`core`: 4096) is summed in
// double in a fixed order.
#include "cae/forward.hpp"

#include <algorithm>

#include "kernels/elu.hpp"
#include "kernels/residual.hpp"

namespace toliman::cae {

Packed pack_encoder(const Parameters &parameters) {
    Packed packed;
    for (size_t s = 0; s < kStages; s++) {
        const Stage &stage = stage_of(*parameters.layout, s);
        packed[s].resize(stage.packed());
        stage.pack_down(parameters[conv_weight(s)], stage.encoder_factor(), packed[s].data());
    }
    return packed;
}

Packed pack_decoder(const Parameters &parameters) {
    Packed packed;
    for (size_t s = 0; s < kStages; s++) {
        const Stage &stage = stage_of(*parameters.layout, s);
        packed[s].resize(stage.packed());
        stage.pack_up(parameters[deconv_weight(s)], 1.0f, packed[s].data());
    }
    return packed;
}

Images::Images(const Layout &layout) : start_() {
    constexpr size_t kLine = 64 / sizeof(float); // of the cache
    size_t size = 0;
    for (size_t level = 0; level <= kStages; level++) {
        const size_t side = layout.side >> level, channels = kChannels[level], first = (side + 3) * channels;
        start_[level] = size + (kLine - first % kLine) % kLine; // the first pixel inside the border starts a line
        size = (start_[level] + layout.level_size(level) + kLine - 1) / kLine * kLine;
    }
    memory_.resize(size);
}

Pooling::Pooling(const Layout &layout) {
    for (size_t s = 0; s < kStages; s++) {
        switches[s].resize(stage_of(layout, s).switches());
        dense[s].resize(stage_of(layout, s).dense());
    }
}

void put_inside(const float *image, size_t rows, size_t cols, size_t channels, float *bordered) noexcept {
    for (size_t r = 0; r < rows; r++)
        std::copy_n(image + r * cols * channels, cols * channels, bordered + ((r + 1) * (cols + 2) + 1) * channels);
}

void get_inside(const float *bordered, size_t rows, size_t cols, size_t channels, float *image) noexcept {
    for (size_t r = 0; r < rows; r++)
        std::copy_n(bordered + ((r + 1) * (cols + 2) + 1) * channels, cols * channels, image + r * cols * channels);
}

double encode(const Parameters &parameters, const Packed &encoder, Images &images, Pooling *pooling) noexcept {
    const Layout &layout = *parameters.layout;
    for (size_t s = 0; s < kStages; s++)
        stage_of(layout, s).encode(images[s], encoder[s].data(), parameters[conv_bias(s)], images[s + 1],
                                   pooling != nullptr ? pooling->switches[s].data() : nullptr);
    double latent = static_cast<double>(parameters[kLatentBias][0]);
    for (size_t r = 0; r < layout.deep_side(); r++)
        latent += latent_of_row(parameters, r, images[kStages] + layout.feature_at(r));
    return latent;
}

double latent_of_row(const Parameters &parameters, size_t r, const float *features) noexcept {
    const size_t row = parameters.layout->deep_side() * kDeepChannels;
    return kernels::residual_kernels().inner_float(features, parameters[kLatentWeight] + r * row, row);
}

void decode(const Parameters &parameters, const Packed &decoder, float latent, Images &images,
            Pooling &pooling) noexcept {
    const Layout &layout = *parameters.layout;
    const float *weight = parameters[kExpandWeight], *bias = parameters[kExpandBias];
    const size_t size = layout.deep_side() * kDeepChannels;
    for (size_t r = 0; r < layout.deep_side(); r++) {
        float *row = images[kStages] + layout.feature_at(r);
        for (size_t i = 0; i < size; i++, weight++, bias++)
            row[i] = latent * *weight + *bias;
        kernels::elu_kernels().elu(row, size);
    }
    for (size_t s = kStages; s-- > 0;) {
        stage_of(layout, s).up(images[s + 1], decoder[s].data(), parameters[deconv_bias(s)], pooling.switches[s].data(),
                               pooling.dense[s].data(), images[s]);
        if (s > 0)
            kernels::elu_kernels().elu(images[s], layout.shapes[s].fine());
    }
}

} // namespace toliman::cae
