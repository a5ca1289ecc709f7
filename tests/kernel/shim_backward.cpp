// C interface of the autoencoder's forward and backward pass: loss and gradient of one image.
#include <algorithm>

#include "cae/backward.hpp"

using namespace toliman::cae;

// Mean squared difference between image [256][256] and its reconstruction; the gradient with respect to all weights.
extern "C" double shim_loss_and_gradient(uint32_t layout_id, const float *weights, const float *image,
                                         float *gradient) {
    const Layout &layout = *find_layout(layout_id);
    Parameters parameters, result;
    std::copy_n(weights, kParameters, parameters.values.begin());
    const Operators operators(layout, parameters);
    Pass pass(layout);
    put_inside(image, kSide, kSide, 1, pass.encoder[0]);
    pass.latent = static_cast<float>(encode(layout, parameters, operators.encoder_down, pass.encoder, &pass.pooling));
    decode(layout, parameters, operators.decoder_up, pass.latent, pass.decoder, pass.pooling);
    double loss = 0;
    for (size_t r = 0; r < kSide; r++)
        for (size_t c = 0; c < kSide; c++) {
            const size_t at = (r + 1) * kInputStride + 1 + c;
            const float error = pass.decoder[0][at] - image[r * kSide + c];
            loss += static_cast<double>(error) * static_cast<double>(error);
            pass.gradient[0][at] = error * (2.0f / kPixels);
        }
    Gradient sum(layout);
    sum.add(parameters, operators, pass);
    sum.get(result);
    std::copy(result.values.begin(), result.values.end(), gradient);
    return loss / kPixels;
}

extern "C" size_t shim_tensor(size_t tensor, size_t *count) {
    *count = kTensorTable[tensor].count();
    return tensor_offset(tensor);
}
