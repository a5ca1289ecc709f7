// What a calibration is worth: residuals, uncertainty, verdict.
#pragma once
#include "calibrate/calibrate.hpp"

namespace toliman::calibrate {

// Residual of a frame over its standard deviations, [rows][cols].
Buffer<double> whitened_frame(const Problem &problem, const Point &point, size_t frame);

// Sets everything of `out` that follows from a maximum.
void judge(const Problem &problem, const Point &point, const Linearisation &normal, Calibration &out);

} // namespace toliman::calibrate
