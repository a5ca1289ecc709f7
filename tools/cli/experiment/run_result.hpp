// result.json of a run, schema toliman-run/2.
#pragma once
#include <string>
#include <vector>

#include "experiment/pipeline.hpp"
#include "experiment/run_images.hpp"

namespace cli {

// rotation_deg: position angle of the detector's +y axis.
std::string run_result(const Scene &scene, double rotation_deg, const Cadence &cadence, const Pipeline &pipeline,
                       const std::vector<RunImage> &images);

} // namespace cli
