// When the telescope points at the stars: the table of --on-target, and the exposures of a scene.
#pragma once
#include "scenes/leap_seconds.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

// A window in which it does.
struct TargetWindow {
    int64_t start_ns, end_ns; // TAI
};

// In order of time; they do not overlap.
std::vector<TargetWindow> read_on_target(const std::string &path, const LeapSeconds &leap_seconds);

// The parts of an exposure within the windows: start and end of each in turn, TAI.
std::vector<int64_t> parts_of(const std::vector<TargetWindow> &windows, int64_t start_ns, int64_t end_ns);

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
