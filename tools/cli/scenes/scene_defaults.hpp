// What a scene says about the times, the orbit and the observer of its frames: defaults of options.
#pragma once
#include "common/common.hpp"

namespace cli {

// What is reported once the options have been accepted: those that differ from the scene.
using Notes = std::vector<std::string>;

struct SceneDefaults {
    std::string path; // of the scene; "" for none, which has no defaults
    std::string
        system; // "alpha-cen" or the path of a system file, of binary.orbit; "" for an orbit of elements, or none
    // Of binary.observer. The Earth's centre has neither a file nor an altitude.
    bool has_observer = false;
    std::string observer_file;
    std::optional<double> altitude_km, node_hours;
    double exposure_s = 0; // cadence.exposure_s; 0: unknown
    std::vector<double>
        on_target_s;            // cadence.on_target_s: start and end of each interval, from the start of an exposure
    std::string on_target_file; // cadence.on_target, a table of windows; "" for none
};

// Reads a scene file that the library has checked.
SceneDefaults scene_defaults(const std::string &path);

// The system of --system. Without it, that of the scene where it is wanted, or "". One that differs is reported.
std::string system_or_that_of(const SceneDefaults &scene, const std::string &given, bool is_wanted, Notes &notes);

} // namespace cli
