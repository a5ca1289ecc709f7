// From the pupil to a star's image in every wavelength of its light, with exact derivatives by position.
#pragma once
#include <functional>

#include "base/buffer.hpp"
#include "optics/light.hpp"
#include "optics/pupil.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

// Expected photons per pixel, per px and px^2 for the derivatives; [rows][cols].
struct StarImages {
    Buffer<double> image, dx, dy;
    Buffer<double> curvature; // second derivative along light.axis
};

enum class Detail { image, gradient, curvature }; // each includes those before

// Images of star 0 (A) or 1 (B), moved by displacement_px along light.axis. `done` hears the fraction on the caller's
// thread and may throw. The bits do not depend on workers.
StarImages propagate(const Scene &scene, const Pupil &pupil, const Light &light, size_t star, double displacement_px,
                     Detail detail, unsigned workers, const std::function<void(double)> &done = nullptr);

} // namespace toliman::optics
