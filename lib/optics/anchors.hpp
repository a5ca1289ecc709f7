// Series of both stars' places about points of their orbit. Each serves frames of its stretch of time; it is made when
// first needed, and the last few are kept.
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>

#include "optics/detector.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

// Expected electrons [rows][cols] with the stars at an offset, and their derivatives by each star's place.
struct Anchor {
    Offsets offset_px = {};
    Buffer<double> star[2]; // B empty without one
    std::vector<Derivative> places[2];
    Buffer<double> scale, focus, focus_curve; // of the whole frame; empty where systematics change neither
};

// Any number of threads may ask at the same time. While an anchor is made, on the simulator's workers, all of them
// wait, those with an anchor of their own too: frames in order wait once an anchor, which serves many.
class Anchors {
  public:
    Anchors(const Scene &scene, const Imager &imager, const Plan &plan, const DetectorStages &detector,
            const Light &light) // all outlive it
        : scene_(scene), imager_(imager), plan_(plan), detector_(detector), light_(light) {}

    std::shared_ptr<const Anchor> near(double days) const;

  private:
    Anchor make(double days) const;

    const Scene &scene_;
    const Imager &imager_;
    const Plan &plan_;
    const DetectorStages &detector_;
    const Light &light_;
    mutable std::mutex mutex_;
    mutable std::deque<std::pair<int64_t, std::shared_ptr<const Anchor>>> kept_; // the last used first
};

} // namespace toliman::optics
