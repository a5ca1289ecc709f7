// What an estimator must know of the frames: the one thing that the simulator hands to lib/cae and lib/linear.
#pragma once
#include <string>
#include <vector>

#include "base/buffer.hpp"

namespace toliman {

struct FrameModel {
    std::string source; // how messages call the scene
    size_t rows = 0, cols = 0;
    Buffer<double> reference;  // rows*cols, expected counts of the frame without displacement
    double background = 0;     // of the reference in every pixel that is no light: dark current, bias
    Buffer<double> variance;   // rows*cols, variance of a frame's counts (photons + read noise), > 0
    Buffer<double> derivative; // rows*cols, d(reference)/d(separation), counts per pixel of separation
    struct Nuisance {
        std::string name; // "flux_a" ...
        Buffer<double> image;
    };
    std::vector<Nuisance> projected; // derivative images that estimators must be blind to; empty = none
    double crb_px = 0;               // Cramer-Rao bound of the separation a frame, exactly `projected` free
    uint64_t scene_digest = 0;       // FNV-1a of the scene, for provenance
};

} // namespace toliman
