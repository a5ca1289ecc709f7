// What is legal in a scene but perhaps not meant, told to the log.
#pragma once
#include "optics/simulator.hpp"

namespace toliman::optics {

// What the plan tells.
void remark(const Scene &scene, const Light &light, const Plan &plan, const Log &log);

// The same and what the detector cannot hold, by a rough image: before the scene's own are made.
void remark_beforehand(const Outline &outline, const Settings &settings);

} // namespace toliman::optics
