// Sums over vectors of the unknowns of all cells or pixels, in their order.
#pragma once
#include "base/buffer.hpp"

namespace toliman::calibrate {

inline double dot(const Buffer<double> &a, const Buffer<double> &b) noexcept {
    double sum = 0;
    for (size_t i = 0; i < a.size(); i++)
        sum += a[i] * b[i];
    return sum;
}

// a += factor b
inline void add_scaled(double factor, const Buffer<double> &b, Buffer<double> &a) noexcept {
    for (size_t i = 0; i < a.size(); i++)
        a[i] += factor * b[i];
}

} // namespace toliman::calibrate
