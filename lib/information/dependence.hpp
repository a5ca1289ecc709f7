// Warnings about images of preprocess.project that are combinations of each other.
#pragma once
#include "base/progress.hpp"
#include "frame/frame_model.hpp"

namespace toliman::information {

// Logs each projected image that the projection drops, and each of which less than 1e-2 of the norm remains after the
// projection of the others. Computes nothing without a log.
void warn_of_dependence(const FrameModel &model, const Log &log);

} // namespace toliman::information
