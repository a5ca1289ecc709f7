// The images that a scene needs, in expected electrons of a frame (photons, where the detector has no qe), and the
// series that makes frames of them.
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/detector.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

constexpr double kMostPhotons = 1e12; // a pixel: the Poisson generator's range

// All [rows][cols].
struct Images {
    Buffer<double> star[2];             // B empty without one
    Buffer<double> both;                // the frame without displacement, with its dark current
    std::vector<Buffer<double>> motion; // derivatives along the displacement, the first first; one more than the
                                        // series takes, for what it leaves out
    std::vector<Derivative> places[2];  // derivatives by each star's place, where systematics move them
    Buffer<double> shift_x, shift_y;    // derivatives of a common shift, per px
    Buffer<double> roll;                // of a turn of the sky about the frame's centre, from x towards y, per rad
    Buffer<double> scale;               // of a stretch of the whole image about the frame's centre, relative
    Buffer<double> focus;               // of defocus, per nm rms
    Buffer<double> focus_curve;         // second derivative, per nm^2; empty where systematics change no focus
    Buffer<double> background;          // of light that falls on all pixels alike, per photon in each
    Buffer<double> variance;            // of a frame, electrons^2, > 0
    double peak_photons = 0;            // brightest pixel before the detector
    double total_photons = 0;
};

// Propagates both stars. Where the scene gives the peak, scales light to it.
Images make_images(const Scene &scene, const Imager &imager, const Plan &plan, const DetectorStages &detector,
                   Light &light, const Progress &progress);

} // namespace toliman::optics
