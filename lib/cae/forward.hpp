// Forward passes of encoder and decoder, layout by layout, and the memory they take.
#pragma once
#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>

#include "base/buffer.hpp"
#include "cae/layout.hpp"
#include "cae/stage.hpp"

namespace toliman::cae {

// All tensors of the layout, one after the other.
struct Parameters {
    Buffer<float> values = Buffer<float>(kParameters, 0.0f);
    float *operator[](size_t tensor) noexcept { return &values[tensor_offset(tensor)]; }
    const float *operator[](size_t tensor) const noexcept { return &values[tensor_offset(tensor)]; }
};

// Kernels of all stages as a kind of operation reads them.
using Packed = std::array<Buffer<float>, kStages>;
Packed pack_encoder(const Layout &layout, const Parameters &parameters); // its down operations
Packed pack_decoder(const Layout &layout, const Parameters &parameters); // its up operations

// Floats of the bordered image at a level: 0 is the network's input or output, kStages the features.
constexpr size_t level_size(size_t level) noexcept {
    return level < kStages ? kShapes[level].fine() : kShapes[kStages - 1].coarse();
}
constexpr size_t kInputStride = kSide + 2; // of level 0's rows, the first pixel at kInputStride + 1

// Working memory of one pass, the images of all levels, with borders of zeros; what they hold inside is up to the pass.
// One allocation, which the system's allocator then keeps at hand from call to call; several large ones it would give
// back and fetch again, page by page.
class Images {
  public:
    Images();
    float *operator[](size_t level) noexcept { return memory_.get() + start_[level]; }
    const float *operator[](size_t level) const noexcept { return memory_.get() + start_[level]; }

  private:
    struct Free {
        void operator()(float *memory) const noexcept { std::free(memory); }
    };
    std::array<size_t, kStages + 1> start_;
    std::unique_ptr<float[], Free> memory_;
};

// The frame's switches and the working memory of stages that un-pool; empty for the others.
struct Pooling {
    explicit Pooling(const Layout &layout);
    std::array<Buffer<Switch>, kStages> switches;
    std::array<Buffer<float>, kStages> dense;
};

// Copies between an image [rows][cols][channels] and the inside of its bordered form.
void put_inside(const float *image, size_t rows, size_t cols, size_t channels, float *bordered) noexcept;
void get_inside(const float *bordered, size_t rows, size_t cols, size_t channels, float *image) noexcept;

// Latent of the image in images[0]; images[k] are the stages' results. pooling may be NULL when the switches are not
// asked for.
double encode(const Layout &layout, const Parameters &parameters, const Packed &encoder, Images &images,
              Pooling *pooling) noexcept;

// images[0] from a latent, by way of images[kStages] and down.
void decode(const Layout &layout, const Parameters &parameters, const Packed &decoder, float latent, Images &images,
            Pooling &pooling) noexcept;

} // namespace toliman::cae
