// Forward passes of encoder and decoder for any layout, and their working memory.
#pragma once
#include <array>
#include <cstddef>

#include "base/buffer.hpp"
#include "cae/layout.hpp"
#include "cae/stage.hpp"

namespace toliman::cae {

// All tensors of a layout in one array, in the order of its table.
struct Parameters {
    explicit Parameters(const Layout &of) : layout(&of), values(of.parameters(), 0.0f) {}
    const Layout *layout;
    Buffer<float> values;
    float *operator[](size_t tensor) noexcept { return &values[layout->offsets[tensor]]; }
    const float *operator[](size_t tensor) const noexcept { return &values[layout->offsets[tensor]]; }
};

// Convolution kernels of all stages, packed in the order in which one kind of operation reads them.
using Packed = std::array<Buffer<float>, kStages>;
Packed pack_encoder(const Parameters &parameters); // for its down operations
Packed pack_decoder(const Parameters &parameters); // for its up operations

// Working memory of one pass: the images of all levels, zeros at first; no operation writes anything else to a border.
// A single allocation, because the system's allocator keeps one block for the next call, but returns several large
// blocks to the system, which then maps and clears their pages again.
class Images {
  public:
    explicit Images(const Layout &layout);
    float *operator[](size_t level) noexcept { return memory_.data() + start_[level]; }
    const float *operator[](size_t level) const noexcept { return memory_.data() + start_[level]; }

  private:
    std::array<size_t, kStages + 1> start_;
    Buffer<float> memory_;
};

// Pooling switches of a frame, and the working memory of stages that un-pool. Empty for layouts with mean pooling.
struct Pooling {
    explicit Pooling(const Layout &layout);
    std::array<Buffer<Switch>, kStages> switches;
    std::array<Buffer<float>, kStages> dense;
};

// Copies between an image [rows][cols][channels] and the interior of its bordered form.
void put_inside(const float *image, size_t rows, size_t cols, size_t channels, float *bordered) noexcept;
void get_inside(const float *bordered, size_t rows, size_t cols, size_t channels, float *image) noexcept;

// Returns the latent of the image in images[0]; images[k] receives the output of stage k - 1. pooling may be NULL if
// the switches are not needed.
double encode(const Parameters &parameters, const Packed &encoder, Images &images, Pooling *pooling) noexcept;

// Part of the latent that row r of the features adds, features [deep_side()][kDeepChannels].
double latent_of_row(const Parameters &parameters, size_t r, const float *features) noexcept;

// Computes the decoder output images[0] from a latent, through images[kStages] to images[1].
void decode(const Parameters &parameters, const Packed &decoder, float latent, Images &images,
            Pooling &pooling) noexcept;

} // namespace toliman::cae
