// The fit of a scene file, or of the scenes of a calibration with windows (--fit, --free).
#pragma once
#include "common/common.hpp"
#include "scenes/scene.hpp"
#include "scenes/windows.hpp"

namespace cli {

// A scene whose frames are fitted. Omits warnings but that of its calibration: they concern simulated frames and
// estimators for stars at rest.
Scene scene_to_fit(const std::string &file, Progress &progress, const std::string &bad_pixels = "");
// A scene that is calibrated: without that warning, too.
Scene scene_to_calibrate(const std::string &file, Progress &progress, const std::string &bad_pixels = "");

// The fit of a scene or, where `file` lists the windows of a calibration, of the scene of each window.
struct SceneFit {
    // free: further parameters, "none" for none; if empty, "self" if the scene is calibrated and has `self_by_default`.
    // Throws Failure, which names --free if that is the reason.
    SceneFit(const std::string &file, const std::string &free, const std::string &bad_pixels, Progress &progress,
             bool self_by_default = false);

    Scene scene; // that of the first window
    toliman::frame_fit fit;

  private:
    SceneFit(const std::string &file, const std::vector<WindowScene> &windows, const std::string &free,
             const std::string &bad_pixels, Progress &progress, bool self_by_default);
};

} // namespace cli
