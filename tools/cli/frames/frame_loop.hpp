// Frames of a scene in chunks, made on every processor and handed on: what `run` and `experiment` share.
#pragma once
#include <functional>
#include <vector>

#include "scenes/scene.hpp"

namespace cli {

// Frames first ... first + total - 1 of (scene, seed): with displacements (`total` of them) or, where null, as the
// cadence has them. `work` takes `count` images, the first of which is frame first + at, and may change them. A signal
// stops it between two chunks. What making the frames took is added to *seconds.
using FrameWork = std::function<void(size_t at, size_t count, double *images)>;
void for_frames(const Scene &scene, uint64_t seed, int64_t first, size_t total, const double *displacements,
                const FrameWork &work, double *seconds = nullptr);

// Variance of the frames over the one that the Cramer-Rao bound counts, mean over pixels; 0 without noise, below 1
// where a scene draws no photon noise.
double noise_share(const Scene &scene, uint64_t seed);
constexpr double kLeastShare = 0.9; // of it, for an efficiency that means something

double mean(const std::vector<double> &values);
double deviation(const std::vector<double> &values);

} // namespace cli
