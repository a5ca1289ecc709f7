// The simulator of a scene file, with progress and remarks on stderr.
#pragma once
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/terminal.hpp"

namespace cli {

// The file that a scene's name stands for: that file or, where there is none, the shipped scene of that name, which is
// told to the log of `options`. A Failure where neither is there.
std::string found_scene(const std::string &name, const toliman_sim_options &options);

// Whether a plan models the stage of that name.
inline bool has_stage(const toliman_sim_plan_info &plan, const char *name) {
    int32_t modelled = 0;
    toliman::check(toliman_sim_get_stage(&plan, name, &modelled));
    return modelled != 0;
}

struct Scene {
    Scene(const std::string &file, Progress &progress);
    Scene(const std::string &file, const toliman_sim_options &options);
    // A variant of the scene file: its files start where those of the file do; without progress and remarks.
    Scene(const std::string &file, const std::string &json);

    std::string path;
    toliman::simulator sim;
    toliman_sim_info info = {};
    size_t pixels() const noexcept { return static_cast<size_t>(info.rows) * static_cast<size_t>(info.cols); }
};

// Times (days) and true displacements (px) of the whole cadence.
struct Cadence {
    explicit Cadence(const Scene &scene);
    std::vector<double> times, displacements;
};

// A Failure for a scene of more or fewer frames than a periodogram on the default grid takes.
void check_cadence(const Scene &scene, const std::string &command);

// "10:20" is frames 10 ... 19, "10" that one, ":" or "" all; within [0, frames].
struct FrameRange {
    FrameRange(const std::string &text, int64_t frames);
    int64_t first, end;
};

} // namespace cli
