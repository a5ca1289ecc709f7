// The linear map between angles on the sky and pixels of the detector.
#pragma once
#include <array>

#include "scene/scene.hpp"

namespace toliman {

// Pixels (x, y) of an angle (u, v) in units of the pixel scale: x = xx u, y = yx u + yy v. The columns of the detector
// are parallel to v.
struct Geometry {
    double xx = 1, yx = 0, yy = 1;

    std::array<double, 2> to_pixels(double u, double v) const noexcept { return {xx * u, yx * u + yy * v}; }
    std::array<double, 2> to_angle(double x, double y) const noexcept { return {x / xx, (y - yx * (x / xx)) / yy}; }
};

Geometry geometry_of(const Detector &detector) noexcept;

// Pixels that an angle of one pixel scale along the binary's axis spans at time 0; along x for a single star.
double pixels_along_axis(const Scene &scene) noexcept;

} // namespace toliman
