// The fitted scene as JSON text.
#pragma once
#include <string>

#include "calibrate/calibrate.hpp"

namespace toliman::calibrate {

// The scene of a window for a file in `folder`: the nominal text with the fitted values. File names that are relative
// stay so. map_file: name of the OPD map; "" = none.
std::string fitted_json(const Calibration &calibration, size_t window, const std::string &folder,
                        const std::string &map_file);

// The OPD map of the fitted scene: that of the nominal scene's file, if any, plus the fitted one. [N][N] in m; empty
// without a fitted map.
Buffer<double> fitted_map(const Calibration &calibration);

// An array [rows][cols] as the content of an .npy file.
std::string npy_of(const Buffer<double> &values, size_t rows, size_t cols);

} // namespace toliman::calibrate
