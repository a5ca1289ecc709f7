// Linear model of the frames: the only data that lib/information passes to the estimators of lib/cae and lib/linear.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/buffer.hpp"
#include "frame/detector_window.hpp"

namespace toliman {

constexpr size_t kMaxProjected = 32; // images that estimators project out

struct FrameModel {
    std::string source; // name of the scene in messages
    size_t rows = 0, cols = 0;
    Buffer<double> reference; // rows*cols, expected counts of the frame without displacement
    double background = 0;    // part of the reference that is not light, equal in every pixel: dark current, bias
    Buffer<double> variance;  // rows*cols, variance of a frame's counts (photons + read noise), > 0; infinite: not used
    Buffer<double> derivative; // rows*cols, d(reference)/d(separation), counts per pixel of separation
    struct Nuisance {
        std::string name; // "flux_a" ...
        Buffer<double> image;
    };
    std::vector<Nuisance> projected;      // derivative images that estimators project out; may be empty
    double crb_px = 0;                    // Cramer-Rao bound of the separation per frame with exactly `projected` free
    uint64_t scene_digest = 0;            // FNV-1a of the scene, for provenance
    std::optional<DetectorWindow> window; // of the scene's frames
};

} // namespace toliman
