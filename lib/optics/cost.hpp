// The cost model: operations, memory and time of a plan.
#pragma once
#include "optics/plan.hpp"

namespace toliman::optics {

// Cost of a plan: the set-up (all images, once) and each frame. Seconds are those of one core.
struct Cost {
    double setup_flops = 0, frame_flops = 0;
    double bytes = 0; // memory, all workers together
    double setup_s = 0, frame_s = 0;
};

Cost cost_of(const Scene &scene, const Pupil &pupil, const Plan &plan);

} // namespace toliman::optics
