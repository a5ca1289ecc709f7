// What the estimators of lib/cae and lib/linear need to know of a scene's frames.
#pragma once
#include "frame/frame_model.hpp"
#include "optics/simulator.hpp"

namespace toliman::information {

// The scene's images in the frame's unit; logs projected images that depend on each other.
FrameModel model_of(const optics::Simulator &simulator, const Log &log);

} // namespace toliman::information
