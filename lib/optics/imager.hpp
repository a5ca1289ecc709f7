// Images of a star on the detector's pixels, made the way the plan says.
#pragma once
#include "optics/plan.hpp"

namespace toliman::optics {

class Imager {
  public:
    // All three outlive the imager; workers > 0.
    Imager(const Scene &scene, const Pupil &pupil, const Plan &plan, unsigned workers)
        : scene_(scene), pupil_(pupil), plan_(plan), workers_(workers) {}

    // As propagate(), in light as the scene has it, on the detector's pixels.
    StarImages images(const Light &light, size_t star, double displacement_px, const Wanted &wanted,
                      const std::function<void(double)> &done = nullptr) const;

  private:
    std::unique_ptr<Transform> transform(const Grid &grid, size_t fields) const;

    const Scene &scene_;
    const Pupil &pupil_;
    const Plan &plan_;
    unsigned workers_;
};

} // namespace toliman::optics
