// Draws the frames of a stream.
#pragma once
#include "frames/scene_fit.hpp"
#include "frames/stream.hpp"
#include "frames/stream_output.hpp"

namespace cli {

constexpr double kFarthestPx = 14; // of the stars from their places in the scene, 1 px less than a fit covers

// Throws Failure for a scene whose frames cannot be those of a stream at this rate.
void check_stream_scene(const Scene &scene, double rate_hz);

// Draws the exposures of the range of indices: the output takes those that are not dropped, the table all.
void draw_stream(const SceneFit &scene, Stream stream, uint64_t seed, const FrameRange &range, StreamOutput &output,
                 TruthTable &truth, Progress &progress);

} // namespace cli
