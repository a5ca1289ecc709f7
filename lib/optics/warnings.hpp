// Warnings about scenes that are valid but perhaps not as intended.
#pragma once
#include "optics/simulator.hpp"

namespace toliman::optics {

// Logs what the verdict of its calibration says against the scene, and the warnings that follow from the plan.
void warn_of_plan(const Scene &scene, const Pupil &pupil, const Light &light, const Plan &plan, const Log &log);

// Logs the same, and where the detector would saturate or overflow, judged by a rough image: for callers that need the
// warnings without the scene's images.
void warn_before_images(const Outline &outline, const Settings &settings);

} // namespace toliman::optics
