// The fitted scene as a file.
#pragma once
#include <string>

#include "calibrate/calibrate.hpp"

namespace toliman::calibrate {

// Writes the scene of a window to `name`, which must end with .json, and its OPD map next to it.
void save_fitted(const Calibration &calibration, size_t window, const std::string &name);

} // namespace toliman::calibrate
