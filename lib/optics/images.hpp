// The images of a scene: stars, reference frame and derivatives, in expected electrons per frame (photons, where the
// detector has no qe).
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/detector.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

constexpr double kMostPhotons = 1e12; // per pixel: the range of the Poisson generator

// All [rows][cols].
struct Images {
    Buffer<double> star[2];             // B empty for a single star
    Buffer<double> both;                // the reference frame: no displacement, dark current included
    std::vector<Buffer<double>> motion; // derivatives of order 1, 2, ... by the displacement; one order more than the
                                        // expansion uses, to predict its truncation
    std::vector<Derivative> position_derivatives[2]; // by each star's position, if systematics move the stars
    Buffer<double> shift_x, shift_y;                 // by a common shift of both stars, per px
    Buffer<double> roll;        // by a roll of the sky about the frame's centre, from x towards y, per rad
    Buffer<double> scale;       // by a relative scale of the whole image about the frame's centre
    Buffer<double> focus;       // by defocus, per nm rms
    Buffer<double> focus_curve; // second derivative by defocus, per nm^2; empty if no systematics change the focus
    Buffer<double> background;  // by uniform light, per photon in each pixel
    Buffer<double> variance;    // of a frame, electrons^2, > 0
    double peak_photons = 0;    // brightest pixel before the detector
    double total_photons = 0;
};

// Propagates both stars. If the scene gives the peak in photons, scales all images and `light` to it.
Images make_images(const Scene &scene, const Imager &imager, const Plan &plan, const DetectorStages &detector,
                   Light &light, const Progress &progress);

} // namespace toliman::optics
