// Vectors in space.
#pragma once
#include <cmath>

#include "backend/erfa.hpp"

namespace toliman::sky {

using erfa::Vector;

inline Vector vector_of(const double values[3], double unit_size = 1) noexcept {
    return {values[0] / unit_size, values[1] / unit_size, values[2] / unit_size};
}

inline Vector sum(const Vector &a, double factor, const Vector &b) noexcept {
    return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

inline double dot(const Vector &a, const Vector &b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline double length(const Vector &a) noexcept {
    return std::sqrt(dot(a, a));
}

} // namespace toliman::sky
