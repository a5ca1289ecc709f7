// What an incomplete model may lack, and calibrations with it.
#pragma once
#include "calibrate/calibrate.hpp"

namespace toliman::calibrate {

// What the model of a calibration that is not complete may lack; Lack, or 0.
uint32_t lacks_of(const Calibration &calibration, const Problem &problem, const Options &options);

// Calibrates and, while the model is incomplete, again with each change that it may need, from the last result. A
// change is kept if the sum of squares falls by more than noise explains. free: text of the parameters, as free_of()
// takes it.
Calibration improve(Problem problem, const std::string &free, const Point &start, Options options);

} // namespace toliman::calibrate
