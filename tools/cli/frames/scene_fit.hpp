// The fit of a scene file, or of the scenes of a calibration with windows (--fit, --free), and banks of networks that
// follow it: until when one can be used.
#pragma once
#include "common/common.hpp"
#include "scenes/scene.hpp"
#include "scenes/windows.hpp"

namespace cli {

// A scene that is calibrated. Omits warnings: they concern simulated frames and estimators for stars at rest.
Scene scene_to_calibrate(const std::string &file, Progress &progress, const std::string &bad_pixels = "");

struct SceneFit {
    Scene scene; // that of the first window
    toliman::frame_fit fit;
};
// The fit of a scene or, where `file` lists the windows of a calibration, of the scene of each window. Omits warnings
// but that of its calibration.
// free: further parameters, "none" for none; if empty, "self" if the scene is calibrated and has `self_by_default`.
// Throws Failure, which names --free if that is the reason.
SceneFit fit_of_scene(const std::string &file, const std::string &free, const std::string &bad_pixels,
                      Progress &progress, bool self_by_default = false);

constexpr double kLeastEfficiency = 0.95; // as of TOLIMAN_BANK_LOW_EFFICIENCY

// Throws Failure, with the type of the file if it is known, unless it is a bank whose networks are all trained.
toliman::network_bank trained_bank(const std::string &path);

// Throws Failure if the bank of the file `path` is for another fit than that of `scene` with the parameters `free`.
void check_bank(const toliman::network_bank &bank, const toliman::frame_fit &fit, const std::string &path,
                const std::string &scene, const std::string &free);

// " --free "scale focus"" of a command line; "" for no names.
std::string free_text(const std::string &free);

// Efficiency of an undisturbed frame.
double efficiency_at(const toliman::network_bank &bank, const toliman::frame_fit &fit, double days);

// "an efficiency of at least 0.95 until 2029-08-03", for undisturbed frames. "" if the scene's stars follow no orbit.
std::string use_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene);
// The same with the command that trains the next bank, for a message. file: the scene as named on the command line.
std::string renewal_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene,
                       const std::string &file, const std::string &free);

} // namespace cli
