// C interface of the autoencoder's forward and backward pass: loss and gradient of one image.
#include <algorithm>

#include "cae/backward.hpp"
#include "cae/encoder_rows.hpp"

using namespace toliman::cae;

namespace {

Parameters parameters_of(uint32_t layout_id, const float *weights) {
    Parameters parameters(*find_layout(layout_id));
    std::copy_n(weights, parameters.values.size(), parameters.values.begin());
    return parameters;
}

} // namespace

// Mean squared difference between image [side][side] and its reconstruction; the gradient with respect to all weights.
extern "C" double shim_loss_and_gradient(uint32_t layout_id, const float *weights, const float *image,
                                         float *gradient) {
    const Layout &layout = *find_layout(layout_id);
    const size_t side = layout.side;
    Parameters result(layout);
    const Parameters parameters = parameters_of(layout_id, weights);
    const Operators operators(parameters);
    Pass pass(layout);
    put_inside(image, side, side, 1, pass.encoder[0]);
    pass.latent = static_cast<float>(encode(parameters, operators.encoder_down, pass.encoder, &pass.pooling));
    decode(parameters, operators.decoder_up, pass.latent, pass.decoder, pass.pooling);
    double loss = 0;
    const auto pixels = static_cast<float>(layout.pixels());
    for (size_t r = 0; r < side; r++)
        for (size_t c = 0; c < side; c++) {
            const size_t at = layout.input_at(r) + c;
            const float error = pass.decoder[0][at] - image[r * side + c];
            loss += static_cast<double>(error) * static_cast<double>(error);
            pass.gradient[0][at] = error * (2 / pixels);
        }
    Gradient sum(layout);
    sum.add(parameters, operators, pass);
    sum.get(result);
    std::copy(result.values.begin(), result.values.end(), gradient);
    return loss / static_cast<double>(pixels);
}

// Latent of an image [side][side], of whole images and, for mean pooling, row by row.
extern "C" double shim_latent(uint32_t layout_id, const float *weights, const float *image) {
    const Parameters parameters = parameters_of(layout_id, weights);
    const size_t side = parameters.layout->side;
    Images images(*parameters.layout);
    put_inside(image, side, side, 1, images[0]);
    return encode(parameters, pack_encoder(parameters), images, nullptr);
}

extern "C" double shim_latent_by_rows(uint32_t layout_id, const float *weights, const float *image) {
    const Parameters parameters = parameters_of(layout_id, weights);
    const Packed packed = pack_encoder(parameters);
    const size_t side = parameters.layout->side;
    EncoderRows rows(*parameters.layout);
    rows.start(parameters, packed);
    for (size_t r = 0; r < side; r += kBand) {
        for (size_t i = 0; i < kBand; i++)
            std::copy_n(image + (r + i) * side, side, rows.band() + i * rows.band_stride());
        rows.push_band();
    }
    return rows.latent();
}

extern "C" size_t shim_tensor(uint32_t layout_id, size_t tensor, size_t *count) {
    const Layout &layout = *find_layout(layout_id);
    *count = layout.tensors[tensor].count();
    return layout.offsets[tensor];
}
