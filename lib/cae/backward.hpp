// Backward pass of the whole autoencoder: gradient of a loss of the decoder output with respect to all weights.
#pragma once
#include <cstddef>

#include "cae/forward.hpp"

namespace toliman::cae {

// Packed kernels of every operation of a forward and a backward pass, for the weights of one training step.
struct Operators {
    explicit Operators(const Parameters &parameters);
    Packed encoder_down, encoder_up, decoder_up, decoder_down;
};

// Working memory of the forward and backward pass of one image.
struct Pass {
    explicit Pass(const Layout &layout) : encoder(layout), decoder(layout), gradient(layout), pooling(layout) {}
    Images encoder, decoder, gradient;
    Pooling pooling;
    float latent = 0;
};

// Accumulates the gradients of any number of images.
class Gradient {
  public:
    explicit Gradient(const Layout &layout);

    // Adds the gradient of one image. pass holds its forward pass and, in gradient[0], the derivative of the loss with
    // respect to the decoder output, with a border of zeros. pass.gradient is overwritten.
    void add(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept;

    void add(const Gradient &other) noexcept;
    void clear() noexcept;

    // Copies the sum in the order of the weights.
    void get(Parameters &out) const noexcept;

  private:
    void add_decoder(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept;
    void add_encoder(const Operators &operators, Pass &pass) noexcept;

    const Layout &layout_;
    Parameters sums_;                // sums over images: biases and dense weights
    Packed encoder_, decoder_, one_; // packed convolution kernels: sums over images; one_: the current image
};

} // namespace toliman::cae
