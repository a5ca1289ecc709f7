// The images that a scene needs, in expected photons of a frame, and the series that makes frames of them.
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/light.hpp"
#include "optics/pupil.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

struct Images {
    Buffer<double> star[2];    // B empty without one
    Buffer<double> both;       // the frame without displacement
    Buffer<double> separation; // first and second derivative along the displacement, per px and px^2
    Buffer<double> curvature;
    Buffer<double> shift_x, shift_y; // derivatives of a common shift, per px
    Buffer<double> variance;         // of the counts, photons^2, > 0
};

// Propagates both stars. Where the scene gives the peak, scales light to it.
Images make_images(const Scene &scene, const Pupil &pupil, Light &light, unsigned workers, const Progress &progress);

} // namespace toliman::optics
