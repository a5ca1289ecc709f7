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
class RunFolder {
  public:
    explicit RunFolder(const std::string &path);
    // Returns the text of result.json, schema toliman-run/2.
    std::string write(const RunFiles &files);

  private:
    void write_tables(const RunFiles &files);
    OutputFolder folder_;
};

} // namespace cli
