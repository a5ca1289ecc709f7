// The folder of a run's results: all files or none.
#pragma once
#include "run/pipeline.hpp"

namespace cli {

// Everything that a run writes.
struct RunFiles {
    const Scene &scene;
    const std::string &scene_text;
    double rotation_deg; // position angle of the detector's +y axis
    const Cadence &cadence;
    const Pipeline &pipeline;
};

// Opens every file before the computation, so that an unwritable folder fails at once.
void open_files(OutputFolder &folder);
// Returns the text of result.json, schema toliman-run/2.
std::string write(OutputFolder &folder, const RunFiles &files);

} // namespace cli
