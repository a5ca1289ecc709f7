// Expected frames with moved stars: by systematics, along their orbit, or by a signal beyond the expansion.
#pragma once
#include <memory>
#include <mutex>

#include "base/memory.hpp"
#include "optics/atlas.hpp"
#include "optics/detector.hpp"
#include "optics/systematics.hpp"

namespace toliman::optics {

// Any number of threads may call expect() at the same time. The first frame computes the atlas, on the simulator's
// workers, while the others wait.
class MovedStars {
  public:
    MovedStars(const Scene &scene, const Pupil &pupil, const Plan &plan, const Imager &imager,
               const DetectorStages &detector, const Light &light) // all must outlive the object
        : scene_(scene), pupil_(pupil), plan_(plan), imager_(imager), detector_(detector), light_(light) {}

    // Expected electrons [rows][cols] of a frame `days` after time 0.
    void expect(double displacement_px, const Disturbances &disturbances, double days, double *image) const;

  private:
    const Atlas &atlas() const;
    void add_interpolated(size_t star, const Place &place, const std::vector<double> &weights, double *image) const;
    void add_propagated(size_t star, const Place &place, const std::vector<double> &weights, double *image) const;

    const Scene &scene_;
    const Pupil &pupil_;
    const Plan &plan_;
    const Imager &imager_;
    const DetectorStages &detector_;
    const Light &light_;
    const Memory memory_ = current_memory();
    mutable std::mutex mutex_;
    mutable std::unique_ptr<Atlas> atlas_;
};

} // namespace toliman::optics
