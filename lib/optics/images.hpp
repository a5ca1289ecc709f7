// The images that a scene needs, in expected photons of a frame, and the series that makes frames of them.
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

// All [rows][cols].
struct Images {
    Buffer<double> star[2];             // B empty without one
    Buffer<double> both;                // the frame without displacement
    std::vector<Buffer<double>> motion; // derivatives along the displacement, the first first; one more than the
                                        // series takes, for what it leaves out
    Buffer<double> shift_x, shift_y;    // derivatives of a common shift, per px
    Buffer<double> roll;                // of a turn of the sky about the frame's centre, from x towards y, per rad
    Buffer<double> scale;               // of a stretch of the whole image about the frame's centre, relative
    Buffer<double> focus;               // of defocus, per nm rms
    Buffer<double> background;          // of light that falls on all pixels alike, per photon in each
    Buffer<double> variance;            // of the counts, photons^2, > 0
};

// Propagates both stars. Where the scene gives the peak, scales light to it.
Images make_images(const Scene &scene, const Imager &imager, const Plan &plan, Light &light, const Progress &progress);

} // namespace toliman::optics
