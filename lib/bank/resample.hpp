// Images moved by any displacement.
#pragma once
#include "base/buffer.hpp"
#include "base/view.hpp"

namespace toliman::bank {

// Used by one thread at a time.
class Resampler {
  public:
    // For images of at most this many columns, of source and result.
    explicit Resampler(size_t cols);

    // result(r, c) = source(r + y, c + x), interpolated; 0 outside the source. Exchanging source and result, with the
    // opposite displacement, gives the adjoint operator.
    void move(ImageView<const double> source, double x, double y, ImageView<double> result) noexcept;

  private:
    Buffer<double> padded_; // a line with zeros outside the source
};

} // namespace toliman::bank
