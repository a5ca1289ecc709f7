// The estimator of a command: a network (--weights), the template of a scene (--template) or its fit (--fit).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "frames/network.hpp"

namespace CLI {
class App;
}

namespace cli {

struct EstimatorOptions {
    void add_to(CLI::App &command);
    void check() const; // of what needs no file
    std::string weights, scene, fit, free;
};

// One of the three. It must outlive a tracker that uses it.
struct Estimator {
    Estimator() = default;
    // Reads the file that was given.
    Estimator(const EstimatorOptions &given, Progress &progress);

    std::optional<Network> network;
    toliman::linear_estimator linear;
    toliman::frame_fit fit;
    int64_t rows = 0, cols = 0; // of its images
    double exposure_s = 0;      // of its scene; 0: unknown
    std::vector<double> times;  // days, of the frames of a fit's scene
};

} // namespace cli
