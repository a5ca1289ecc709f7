// A network: weights of the layout and the preprocessing they belong to; encoding, decoding and reconstruction.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/view.hpp"
#include "cae/layout.hpp"
#include "cae/preprocess.hpp"

namespace toliman::cae {

// All tensors of the layout, one after the other.
struct Parameters {
    Buffer<float> values = Buffer<float>(kParameters, 0.0f);
    float *operator[](size_t tensor) noexcept { return &values[tensor_offset(tensor)]; }
    const float *operator[](size_t tensor) const noexcept { return &values[tensor_offset(tensor)]; }
};

// The convolutions as the kernels read them.
struct Packed {
    std::array<Buffer<float>, kStages> down, up;
};

// Floats of the bordered image at a level: 0 is the network's input or output, kStages the features.
constexpr size_t level_size(size_t level) noexcept {
    return level < kStages ? kFlight.stages[level].fine() : kFlight.stages[kStages - 1].coarse();
}

// Working memory of one pass, the images of all levels. One allocation, which the system's allocator then keeps at hand
// from call to call; several large ones it would give back and fetch again, page by page.
class Images {
  public:
    Images();
    float *operator[](size_t level) noexcept { return memory_.data() + start_[level]; }

  private:
    std::array<size_t, kStages + 1> start_;
    Buffer<float> memory_;
};

// Copies between an image [rows][cols][channels] and the inside of its bordered form.
void put_inside(const float *image, size_t rows, size_t cols, size_t channels, float *bordered) noexcept;
void get_inside(const float *bordered, size_t rows, size_t cols, size_t channels, float *image) noexcept;

// What a reconstruction is worth; the images scaled by the frame's extremes.
struct Quality {
    double mmse, mssim, photon_floor;
};

class Network {
  public:
    // Weights must be finite. cosine is 0 while untrained.
    Network(Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained, double cosine);

    const Preprocess &preprocess() const noexcept { return preprocess_; }
    const Parameters &parameters() const noexcept { return parameters_; }
    uint64_t seed() const noexcept { return seed_; }
    bool trained() const noexcept { return trained_; }
    double cosine() const noexcept { return cosine_; }

    // Latent in px of one frame. Status::argument for a non-finite count, Status::range for a latent beyond float.
    double encode(ImageView<const double> frame) const;

    // The same for counts [count][rows][cols].
    void encode_many(const double *counts, size_t count, unsigned workers, double *latents) const;

    // Whitened residual image [kPixels] for a latent in px. Status::argument for a latent beyond 1e6 px, Status::range
    // when weights are so large that the image overflows.
    void decode(double latent, double *image) const;

    // Frame as the network sees it again, image [kPixels] in counts. Errors as of encode; Status::range for a latent
    // beyond 1e6 px and an image that overflows.
    void reconstruct(ImageView<const double> frame, double *image) const;

  private:
    struct Workspace;
    double encode(ImageView<const double> frame, Workspace &workspace) const;
    double features_to_latent(float *features) const noexcept;
    void paint(double latent, double *image) const;

    Preprocess preprocess_;
    Parameters parameters_;
    Packed packed_;
    uint64_t seed_;
    bool trained_;
    double cosine_;
};

// Status::argument for a frame without contrast.
Quality quality(const Network &network, ImageView<const double> frame, const double *image);

} // namespace toliman::cae
