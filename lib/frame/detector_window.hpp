// Windows that a camera reads of its detector, and the bad pixels that are known in them.
//
// Method: a scene's bad pixels are places on the detector, given in the scene's own window. In a frame of another
// window they are elsewhere: pixel (row, column) of the scene is pixel (row - d, column - e) of a frame whose window is
// (d, e) px further. Pixels that are bad in the scene's window only stay unused: a loss of light, not of truth. Of
// pixels that the scene's window does not have, nothing is known; a bad one is found by its residual
// (frame/bad_pixels.hpp).
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "frame/bad_pixels.hpp"

namespace toliman {

// Place on the detector of a frame's first pixel.
struct DetectorWindow {
    int64_t row = 0, col = 0;
    bool operator==(const DetectorWindow &o) const noexcept { return row == o.row && col == o.col; }
};

class KnownBadPixels {
  public:
    KnownBadPixels() = default; // none
    // row * cols + col of those of the scene, increasing; own: its window, without which they do not move.
    KnownBadPixels(size_t rows, size_t cols, std::vector<size_t> pixels, const std::optional<DetectorWindow> &own);
    // Of the pixels that are not used, those of infinite variance.
    KnownBadPixels(size_t rows, size_t cols, const Buffer<double> &variance, const std::optional<DetectorWindow> &own);

    bool move_with(const DetectorWindow &window) const noexcept {
        return own_ && !(*own_ == window) && !pixels_.empty();
    }
    // Adds the pixels that are bad in a frame of this window, but not in the scene's. False if they are too many.
    bool add(const std::optional<DetectorWindow> &window, BadPixels &bad) const noexcept;

  private:
    size_t rows_ = 0, cols_ = 0;
    std::vector<size_t> pixels_;
    std::optional<DetectorWindow> own_;
};

} // namespace toliman
