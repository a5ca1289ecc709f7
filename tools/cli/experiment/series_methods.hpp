// Methods that know nothing of the signal and learn from the series of frames that they are asked about.
#pragma once
#include "experiment/methods.hpp"

namespace cli {

enum class Component { raw, whitened, blocks, dictionary };

// The leading component of the frames: principal of counts, of whitened residuals or of their means over blocks of
// frames, or a sparse dictionary's one atom (lambda 1) of whitened residuals.
std::unique_ptr<Method> make_component(const Scene &scene, Component which, uint64_t seed);

// The chapter's: its layout and input, and mean squared error between both ends over the frames.
toliman_cae_options chapter_network();
constexpr uint32_t kChapterEpochs = 10;
std::unique_ptr<Method> make_unsupervised(const Scene &scene, uint64_t seed);

// A signal ends a training.
int32_t stop_asked(const char *stage, double fraction, void *user_data) noexcept;

} // namespace cli
