// Expansion points (anchors) along the binary's orbit. Each covers the frames of its time interval; it is computed when
// first needed, and the kCachedAnchors used last are cached.
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>

#include "optics/detector.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

// Expected electrons [rows][cols] with the stars at offset_px, and the derivatives by each star's position.
struct Anchor {
    Offsets offset_px = {};
    Buffer<double> star[2]; // B empty for a single star
    std::vector<Derivative> position_derivatives[2];
    Buffer<double> scale, focus, focus_curve; // of the whole frame; empty if systematics change neither
};

// Any number of threads may call near() at the same time. While an anchor is computed, on the simulator's workers, all
// callers wait, including those whose anchor is cached. Frames made in order wait once per anchor.
class Anchors {
  public:
    Anchors(const Scene &scene, const Imager &imager, const Plan &plan, const DetectorStages &detector,
            const Light &light) // all must outlive the object
        : scene_(scene), imager_(imager), plan_(plan), detector_(detector), light_(light) {}

    // The anchor whose interval contains the time `days`.
    std::shared_ptr<const Anchor> near(double days) const;

  private:
    Anchor make(double days) const;

    const Scene &scene_;
    const Imager &imager_;
    const Plan &plan_;
    const DetectorStages &detector_;
    const Light &light_;
    mutable std::mutex mutex_;
    mutable std::deque<std::pair<int64_t, std::shared_ptr<const Anchor>>> cache_; // most recently used first
};

} // namespace toliman::optics
