// When the telescope points at the stars in the exposures of a scene.
#pragma once
#include "scenes/on_target_windows.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

class SceneExposures {
  public:
    // Reads the on-target windows of the scene, if it has some.
    explicit SceneExposures(const SceneDefaults &scene);

    bool has_intervals() const noexcept { return !windows_.empty() || !from_start_.empty(); }
    // Start and end of each interval in turn, TAI, of the exposure with this middle: the whole of it if the scene has
    // no intervals. Empty if no window is in it.
    std::vector<int64_t> at(int64_t middle_ns) const;

  private:
    std::string path_;
    int64_t length_ns_;
    std::vector<int64_t> from_start_;   // of cadence.on_target_s
    std::vector<TargetWindow> windows_; // of cadence.on_target
};

} // namespace cli
