// A frame that is the sum of many short ones, whose places differ: their number, and the distribution of the places.
#pragma once
#include <array>
#include <cstddef>

namespace toliman {

constexpr size_t kCumulants = 22; // of order 3 to 6

// Of light, px about its mean.
struct Spread {
    double frames = 1; // that were added
    double xx = 0, yy = 0, xy = 0;
    std::array<double, kCumulants> cumulants = {}; // xxx, xxy, xyy, yyy, xxxx ... yyyyyy

    bool moves() const noexcept { return xx != 0 || yy != 0; }
    bool any() const noexcept { return frames != 1 || moves(); }
};

} // namespace toliman
