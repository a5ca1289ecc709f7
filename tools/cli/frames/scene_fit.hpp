// The fit of a scene file (--fit, --free).
#pragma once
#include <string>

#include "common/terminal.hpp"
#include "scenes/scene.hpp"

namespace cli {

struct SceneFit {
    // free: further parameters. Throws Failure, which names --free if that is the reason.
    SceneFit(const std::string &file, const std::string &free, Progress &progress);

    Scene scene;
    toliman::frame_fit fit;
};

} // namespace cli
