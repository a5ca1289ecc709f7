// Network: a layout, its weights and the preprocessing they were trained for; encode, decode and reconstruct frames.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/view.hpp"
#include "cae/forward.hpp"
#include "cae/preprocess.hpp"
#include "cae/workspace.hpp"
#include "frame/pixel.hpp"

namespace toliman::cae {

// Quality of a reconstruction: mean squared error, mean structural similarity, and the mean squared error that photon
// noise alone would cause. All refer to images scaled so that the frame spans 0 to 1.
struct Quality {
    double mmse, mssim, photon_floor;
};

class Network {
  public:
    // Weights must be finite and of the preprocessing's layout. cosine: between the latent's gradient and the target; 0
    // while untrained.
    Network(Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained, double cosine);

    const Layout &layout() const noexcept { return *parameters_.layout; }
    const Preprocess &preprocess() const noexcept { return preprocess_; }
    const Parameters &parameters() const noexcept { return parameters_; }
    uint64_t seed() const noexcept { return seed_; }
    bool trained() const noexcept { return trained_; }
    double cosine() const noexcept { return cosine_; }

    // Returns the latent of one frame (px after tied training). Status::argument for a non-finite count, Status::range
    // for a non-finite latent.
    // Bad pixels (frame/bad_pixels.hpp), those beyond the limit both before and after the fit of the target, are
    // replaced by what the fit to the other pixels predicts; likewise those of the scene that are elsewhere in a frame
    // of this window, if it is known. *goodness, unless NULL: of that fit.
    double encode(ImageView<const double> frame, Workspace &work, FrameGoodness *goodness = nullptr,
                  const std::optional<DetectorWindow> &window = {}) const;

    // The same for `count` frames of equal stride, at most kTogether with mean pooling and one with maximum pooling:
    // latents [count], the same bits as one by one; goodness and windows [count] or NULL.
    void encode(const ImageView<const double> *frames, size_t count, Workspace &work, double *latents,
                FrameGoodness *goodness, const std::optional<DetectorWindow> *windows) const;

    // FNV-1a of everything that determines a latent: preprocessing, layout and weights.
    uint64_t digest() const noexcept;

    // Encodes `count` frames into latents [count] and, unless NULL, goodness [count]. The result does not depend on
    // the number of workers.
    void encode_many(const PixelFrames &frames, size_t count, unsigned workers, double *latents,
                     FrameGoodness *goodness) const;

    // Decoder output for a latent (px): the whitened residual image [pixels]. Status::argument for |latent| above
    // 1e6 px, Status::range for an image that overflows, Status::unsupported for layout `paper`, whose decoder needs a
    // frame's pooling switches.
    void decode(double latent, double *image) const;

    // Reconstructed frame, image [pixels] in counts: encode, decode, inverse preprocessing. Errors of encode;
    // Status::range also for |latent| above 1e6 px and for an image that overflows.
    void reconstruct(ImageView<const double> frame, double *image) const;

  private:
    bool repair(const Crop &crop, size_t i, Workspace &work, BadPixels &bad, Preprocess::Fitted &fitted,
                double &latent) const;
    void latents_of_rows(const Crop *crops, size_t count, Workspace &work, double *latents) const;
    double latent_of_image(const Crop &crop, Workspace &work, Pooling *pooling) const;
    void latents_of(const Crop *crops, size_t count, Workspace &work, Pooling *pooling, double *latents) const;
    void run_decoder(double latent, Pooling &pooling, double *image) const;

    Preprocess preprocess_;
    Parameters parameters_;
    Packed encoder_, decoder_;
    uint64_t seed_;
    bool trained_;
    double cosine_;
};

// Compares a frame with its reconstruction, image [pixels] in counts. Status::argument for a constant frame.
Quality quality(const Network &network, ImageView<const double> frame, const double *image);

} // namespace toliman::cae
