// A network: weights of the layout and the preprocessing they belong to; encoding, decoding and reconstruction.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/pixel.hpp"
#include "base/view.hpp"
#include "cae/forward.hpp"
#include "cae/preprocess.hpp"

namespace toliman::cae {

// What a reconstruction is worth; the images scaled by the frame's extremes.
struct Quality {
    double mmse, mssim, photon_floor;
};

// What encoding works in; one a thread.
struct Workspace {
    Images images;
    Buffer<double> scratch;
};

class Network {
  public:
    // Weights must be finite. cosine is 0 while untrained.
    Network(const Layout &layout, Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained,
            double cosine);

    const Layout &layout() const noexcept { return *layout_; }
    const Preprocess &preprocess() const noexcept { return preprocess_; }
    const Parameters &parameters() const noexcept { return parameters_; }
    uint64_t seed() const noexcept { return seed_; }
    bool trained() const noexcept { return trained_; }
    double cosine() const noexcept { return cosine_; }

    // Latent in px of one frame. Status::argument for a non-finite count, Status::range for a latent beyond float.
    double encode(ImageView<const double> frame) const;
    // The same without an allocation; chi_square, unless NULL, becomes that of Preprocess.
    double encode(ImageView<const double> frame, Workspace &work, double *chi_square = nullptr) const;

    // FNV-1a of all that the latents come from.
    uint64_t digest() const noexcept;

    // The same of many frames, and chi_square [count] of each unless NULL.
    void encode_many(const PixelFrames &frames, size_t count, unsigned workers, double *latents,
                     double *chi_square) const;

    // Whitened residual image [kPixels] for a latent in px. Status::argument for a latent beyond 1e6 px, Status::range
    // when weights are so large that the image overflows, Status::unsupported for a layout that needs a frame's
    // switches.
    void decode(double latent, double *image) const;

    // Frame as the network sees it again, image [kPixels] in counts. Errors as of encode; Status::range for a latent
    // beyond 1e6 px and an image that overflows.
    void reconstruct(ImageView<const double> frame, double *image) const;

  private:
    double latent_of(ImageView<const double> frame, Workspace &work, Pooling *pooling) const;
    void paint(double latent, Pooling &pooling, double *image) const;

    const Layout *layout_;
    Preprocess preprocess_;
    Parameters parameters_;
    Packed encoder_, decoder_;
    uint64_t seed_;
    bool trained_;
    double cosine_;
};

// Status::argument for a frame without contrast.
Quality quality(const Network &network, ImageView<const double> frame, const double *image);

} // namespace toliman::cae
