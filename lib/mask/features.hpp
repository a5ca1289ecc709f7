// Features of a mask of cells that are too small to be manufactured.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"

namespace toliman::mask {

// The cells [samples][samples] are 0 or 1. A cell is small if no square of side x side cells of its kind covers it;
// closed cells, where open is 0, count as any kind.

// Flips small cells, or widens what they belong to, until few or none are left.
Buffer<uint8_t> without_small_features(Buffer<uint8_t> cells, size_t samples, size_t side, const Buffer<double> &open);

// The fraction of the open cells that are small.
double small_fraction(const Buffer<uint8_t> &cells, size_t samples, size_t side, const Buffer<double> &open);

} // namespace toliman::mask
