// Expected frames whose stars or optics differ from the scene's: by systematics, along an orbit, or by a signal beyond
// the expansion.
#pragma once
#include <memory>
#include <mutex>

#include "base/memory.hpp"
#include "optics/atlas.hpp"
#include "optics/detector.hpp"
#include "optics/systematics.hpp"

namespace toliman::optics {

// Any number of threads may call expect() at the same time. The first frame computes the atlas, on the simulator's
// workers, or the modes of the pupil, while the others wait; frames are propagated on the caller's thread.
class MovedStars {
  public:
    MovedStars(const Scene &scene, const Pupil &pupil, const Plan &plan, const Imager &imager,
               const DetectorStages &detector, const Light &light) // all must outlive the object
        : scene_(scene), pupil_(pupil), plan_(plan), imager_(imager), detector_(detector), light_(light) {}

    // Expected electrons [rows][cols] of a frame `days` after time 0.
    void expect(double displacement_px, const Disturbances &disturbances, double days, double *image) const;

  private:
    // The instrument in one frame.
    struct Instrument {
        Scene scene;
        Pupil pupil;
        Plan plan;
    };

    const Atlas &atlas() const;
    const std::vector<Mode> &modes() const;
    Instrument instrument_of(const Disturbances &disturbances) const;
    void add_interpolated(size_t star, const Place &place, double flux, double *image) const;
    void add_propagated(const Imager &imager, Light light, size_t star, const Place &place, double flux,
                        double *image) const;

    const Scene &scene_;
    const Pupil &pupil_;
    const Plan &plan_;
    const Imager &imager_;
    const DetectorStages &detector_;
    const Light &light_;
    const Memory memory_ = current_memory();
    mutable std::mutex mutex_;
    mutable std::unique_ptr<Atlas> atlas_;
    mutable std::vector<Mode> modes_; // of the Zernike polynomials that differ from frame to frame
};

} // namespace toliman::optics
