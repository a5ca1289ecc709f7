// Encoder with mean pooling for an image that arrives row by row.
#pragma once
#include <array>
#include <cstddef>

#include "base/buffer.hpp"
#include "cae/forward.hpp"
#include "cae/preprocess.hpp"

namespace toliman::cae {

// To encode an image: start(); for each band of kBand rows from the first on, write it to band() [kBand][band_stride()]
// and push_band(); read latent(), which has the bits of encode(). Reuse it from image to image.
class EncoderRows {
  public:
    explicit EncoderRows(const Layout &layout);
    EncoderRows(const EncoderRows &) = delete; // its pointers are into its own memory, which moves along
    EncoderRows &operator=(const EncoderRows &) = delete;
    EncoderRows(EncoderRows &&) = default;
    EncoderRows &operator=(EncoderRows &&) = default;

    // Of the layout; both must outlive the image.
    void start(const Parameters &parameters, const Packed &encoder) noexcept;
    float *band() noexcept { return levels_[0].fine[0] + 1 + band_stride_; }
    size_t band_stride() const noexcept { return band_stride_; } // floats from row to row, with borders
    void push_band() noexcept;
    double latent() const noexcept { return latent_; }

  private:
    // Part of an image that is the input of a stage.
    struct Level {
        size_t rows;     // pushed so far, with the border
        float *fine[2];  // the last two rows, with the border's columns; of the input: the row before the band
        float *boxes[3]; // the last three rows of box sums
    };

    const float *fine(size_t stage, size_t row) const noexcept;
    float *next(size_t stage) noexcept;
    void advance(size_t stage) noexcept;
    void sum_boxes(size_t stage) noexcept;

    const Layout *layout_;
    size_t band_stride_;
    const Parameters *parameters_ = nullptr;
    const Packed *encoder_ = nullptr;
    double latent_ = 0;
    size_t before_band_ = 0; // bordered row before the band
    std::array<Level, kStages> levels_;
    Buffer<float> memory_;
};

} // namespace toliman::cae
