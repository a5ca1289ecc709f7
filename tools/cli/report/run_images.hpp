// Images of a run, computed anew from what it left.
#pragma once
#include <cstdint>
#include <string>

#include "report/page.hpp"

namespace cli {

// Pupil, point spread functions, a frame, the wobble and the reconstruction. scene_folder: where files that the scene
// names are. A Failure, or the library's error, where they cannot be computed.
void add_run_images(const std::string &folder, const std::string &scene_folder, uint64_t seed, Page &page);

} // namespace cli
