// Encoder of layout `flight` for an image that arrives row by row.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "base/buffer.hpp"
#include "cae/forward.hpp"

namespace toliman::cae {

// To encode an image: start(), push() its kSide rows, read latent(), which has the bits of encode(). Reuse it from
// image to image.
class EncoderRows {
  public:
    EncoderRows();

    // Both must outlive the image.
    void start(const Parameters &parameters, const Packed &encoder) noexcept;
    void push(const float *row) noexcept {
        std::copy_n(row, kSide, next(0));
        advance(0);
    }
    double latent() const noexcept { return latent_; }

  private:
    // Part of an image that is the input of a stage.
    struct Level {
        size_t rows;     // pushed so far, with the border
        float *fine[2];  // the last two rows, with the border's columns
        float *boxes[3]; // the last three rows of box sums
    };

    const float *fine(size_t stage, size_t row) const noexcept;
    float *next(size_t stage) noexcept;
    void advance(size_t stage) noexcept;
    void sum_boxes(size_t stage) noexcept;

    const Parameters *parameters_ = nullptr;
    const Packed *encoder_ = nullptr;
    double latent_ = 0;
    std::array<Level, kStages> levels_;
    Buffer<float> memory_;
};

} // namespace toliman::cae
