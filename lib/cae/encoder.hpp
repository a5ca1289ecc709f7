// Encoder of images that are whitened and projected already: a network without preprocessing and decoder.
#pragma once
#include <optional>

#include "cae/encoder_rows.hpp"
#include "cae/forward.hpp"

namespace toliman::cae {

// Working memory of one thread.
class EncoderWork {
  public:
    explicit EncoderWork(const Layout &layout);

  private:
    friend class Encoder;
    std::optional<EncoderRows> rows_; // with mean pooling
    std::optional<Images> images_;    // with maximum pooling
};

// How the latent of a noisy image depends on a small change of the image. With mean pooling it is the inner product
// with the gradient. Maximum pooling changes its slope and loses information.
struct Response {
    double gain = 1;  // mean change of the latent over that of the inner product
    double share = 1; // of the efficiency of the inner product
};

class Encoder {
  public:
    explicit Encoder(Parameters weights);

    const Layout &layout() const noexcept { return *weights_.layout; }
    const Parameters &weights() const noexcept { return weights_; }
    // d latent/d image at 0, [pixels]; of layout `paper` with mean pooling instead.
    const Buffer<float> &gradient() const noexcept { return gradient_; }
    // Of an image [pixels], in units of its noise. Of layout `paper`, half the difference between those of the image
    // and its negative, because the maxima of noise are positive.
    double latent(const double *image, EncoderWork &work) const noexcept;
    // Estimated from images of unit noise, with and without the gradient's image.
    Response response() const;

  private:
    double latent_of_maxima(const double *image, double factor, Images &images) const noexcept;

    Parameters weights_;
    Packed packed_;
    Buffer<float> gradient_;
};

} // namespace toliman::cae
