// The simulator of a scene file, with progress and warnings on standard error.
#pragma once
#include "common/common.hpp"

namespace cli {

// Options of a simulator or estimator whose warnings go to standard error.
template <class Options> Options with_warnings(Progress &progress) {
    auto options = toliman::sized<Options>();
    options.log = Progress::log;
    options.log_data = &progress;
    return options;
}

// The path of a scene: the file of this name or, if there is none, the shipped scene of this name, which is reported to
// the log of `options`. Throws Failure if neither exists.
std::string scene_path(const std::string &name, const toliman_sim_options &options);

std::vector<toliman_sim_stage> stages_of(const toliman_sim_plan_info &plan);
// Whether a plan models the stage of that name.
bool has_stage(const toliman_sim_plan_info &plan, const std::string &name);

struct Scene {
    // bad_pixels: file that replaces that of the scene; "": none does.
    Scene(const std::string &file, Progress &progress, const std::string &bad_pixels = "");
    Scene(const std::string &file, const toliman_sim_options &options);
    // A variant of a scene file as JSON; its relative file names start at the folder of `file`. No progress or
    // warnings.
    Scene(const std::string &file, const std::string &json);

    std::string path;
    toliman::simulator sim;
    toliman_sim_info info = {};
    size_t pixels() const noexcept { return static_cast<size_t>(info.rows) * static_cast<size_t>(info.cols); }
    // TOLIMAN_SIM_IMAGE_..., [rows][cols].
    toliman_sim_bounds bounds() const; // computes the derivatives
    std::vector<double> image(int32_t kind) const;
    std::vector<double> wavelengths() const; // m
    bool has(const char *stage) const;       // whether the scene models the stage of that name
    // Whether orbit, pointing or roll move the stars, so that only the fit and a bank follow them.
    bool moves() const { return has("moving stars"); }
    // What frames of a real mask need, where the expected error of the pupil cells exceeds the photon noise of a frame;
    // "" otherwise.
    std::string lacks_for_real_frames() const;
};

// Times (days) and true displacements (px) of all frames.
struct Cadence {
    explicit Cadence(const Scene &scene);
    std::vector<double> times, displacements;
};

// From the first frame to one interval after the last, or of a list of times to the last.
double span_days(const Scene &scene);

// Throws Failure if the number of frames is outside the limits of the default frequency grid.
void check_cadence(const Scene &scene, const std::string &command);

// "10:20" means frames 10 ... 19, "10" frame 10, ":" or "" all frames; within [0, frames].
struct FrameRange {
    FrameRange(const std::string &text, int64_t frames);
    int64_t first, end;
};

} // namespace cli
