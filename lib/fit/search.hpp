// Search for the stars of a frame: the common shift from their expected places.
#pragma once
#include <array>

#include "backend/fft.hpp"
#include "base/buffer.hpp"
#include "base/view.hpp"

namespace toliman::fit {

// Used by one thread at a time. Allocates nothing after construction.
class Search {
  public:
    // For frames of this shape and shifts up to `reach` px along each axis.
    Search(size_t rows, size_t cols, double reach);

    // The shift [x, y] (px) from the expected to the given counts, which have all the same offset (bias): that of the
    // largest correlation, interpolated between pixels.
    std::array<double, 2> shift(ImageView<const double> counts, ImageView<const double> expected, double bias) noexcept;

  private:
    size_t rows_, cols_, side_;
    long reach_;
    fft::Square transform_;
};

} // namespace toliman::fit
