// Measured separations of the frames of a state folder.
#pragma once
#include <string>

#include "common/terminal.hpp"
#include "series/reduction.hpp"

namespace cli {

// Those of all accepted and unreduced frames. plate_scale: arcsec per px; otherwise that of the folder. Throws Failure
// if the folder has no separations, and for frames with a list of on-target intervals. Warns of frames whose time on
// target is not known, which are left out.
Measured measured_frames(const std::string &folder, const std::optional<double> &plate_scale, Progress &progress);

} // namespace cli
