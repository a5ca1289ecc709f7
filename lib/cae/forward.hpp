// Forward passes of encoder and decoder for either layout, and their working memory.
#pragma once
#include <array>
#include <cstddef>

#include "base/buffer.hpp"
#include "cae/layout.hpp"
#include "cae/stage.hpp"

namespace toliman::cae {

// All tensors of the layout in one array, in the order of kTensorTable.
struct Parameters {
    Buffer<float> values = Buffer<float>(kParameters, 0.0f);
    float *operator[](size_t tensor) noexcept { return &values[tensor_offset(tensor)]; }
    const float *operator[](size_t tensor) const noexcept { return &values[tensor_offset(tensor)]; }
};

// Convolution kernels of all stages, packed in the order in which one kind of operation reads them.
using Packed = std::array<Buffer<float>, kStages>;
Packed pack_encoder(const Layout &layout, const Parameters &parameters); // for its down operations
Packed pack_decoder(const Layout &layout, const Parameters &parameters); // for its up operations

// Floats of the bordered image at a level: level 0 is the network's input or output, level kStages the features.
constexpr size_t level_size(size_t level) noexcept {
    return level < kStages ? kShapes[level].fine() : kShapes[kStages - 1].coarse();
}
constexpr size_t level_channels(size_t level) noexcept {
    return level < kStages ? kShapes[level].fine_channels : kDeepChannels;
}
constexpr size_t kInputStride = kSide + 2; // floats per row of level 0; its first pixel is at kInputStride + 1

// Working memory of one pass: the images of all levels, zeros at first; no operation writes anything else to a border.
// A single allocation, because the system's allocator keeps one block for the next call, but returns several large
// blocks to the system, which then maps and clears their pages again.
class Images {
  public:
    Images();
    float *operator[](size_t level) noexcept { return memory_.data() + start_[level]; }
    const float *operator[](size_t level) const noexcept { return memory_.data() + start_[level]; }

  private:
    std::array<size_t, kStages + 1> start_;
    Buffer<float> memory_;
};

// Pooling switches of a frame, and the working memory of stages that un-pool. Empty for layout `flight`.
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
double encode(const Layout &layout, const Parameters &parameters, const Packed &encoder, Images &images,
              Pooling *pooling) noexcept;

// Part of the latent that row r of the features adds, features [kDeepSide][kDeepChannels].
double latent_of_row(const Parameters &parameters, size_t r, const float *features) noexcept;

// Computes the decoder output images[0] from a latent, through images[kStages] to images[1].
void decode(const Layout &layout, const Parameters &parameters, const Packed &decoder, float latent, Images &images,
            Pooling &pooling) noexcept;

} // namespace toliman::cae
