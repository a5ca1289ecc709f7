// Backward pass of the whole autoencoder: gradient of a loss of the decoder's image with respect to all weights.
#pragma once
#include <cstddef>

#include "cae/forward.hpp"

namespace toliman::cae {

// Everything that follows from the weights at one step.
struct Operators {
    Operators(const Layout &layout, const Parameters &parameters);
    Packed encoder_down, encoder_up, decoder_up, decoder_down;
};

// One image's way through the network and back.
struct Pass {
    explicit Pass(const Layout &layout) : pooling(layout) {}
    Images encoder, decoder, gradient;
    Pooling pooling;
    float latent = 0;
};

// Sum of gradients of any number of images.
class Gradient {
  public:
    explicit Gradient(const Layout &layout);

    // Adds an image's: pass holds its forward passes, and in gradient[0] that of the loss by the decoder's image, with
    // a border of zeros; gradient is used up.
    void add(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept;

    void add(const Gradient &other) noexcept;
    void clear() noexcept;

    // In the order of the weights.
    void get(Parameters &out) const noexcept;

  private:
    void add_decoder(const Parameters &parameters, const Operators &operators, Pass &pass) noexcept;
    void add_encoder(const Operators &operators, Pass &pass) noexcept;

    const Layout &layout_;
    Parameters sums_;                // of biases and dense weights
    Packed encoder_, decoder_, one_; // of convolutions, packed; one_: of the image at hand
};

} // namespace toliman::cae
