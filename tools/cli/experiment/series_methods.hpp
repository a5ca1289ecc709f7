// Methods without knowledge of the signal, which learn from the series of frames that they evaluate.
#pragma once
#include "experiment/methods.hpp"

namespace cli {

enum class Component { raw, whitened, blocks, dictionary };

// The leading component of the frames: the first principal component of counts, of whitened residuals or of block means
// of these, or the one atom (lambda 1) of a sparse dictionary of whitened residuals.
std::unique_ptr<Method> make_component(const Scene &scene, Component which, uint64_t seed);

// The book chapter's network: its layout and input, trained by the mean squared error of the reconstruction.
toliman_cae_options chapter_network();
constexpr uint32_t kChapterEpochs = 10;
std::unique_ptr<Method> make_unsupervised(const Scene &scene, uint64_t seed);

// Progress callback that cancels a training after a signal.
int32_t stop_asked(const char *stage, double fraction, void *user_data) noexcept;

} // namespace cli
