// Unsupervised training: the network learns to reproduce its input, with the mean squared error as the loss.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/progress.hpp"
#include "cae/network.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

// Fills counts [count][rows][cols] with frames first, first + 1, ...; throws Error on failure.
using FrameSource = std::function<void(size_t first, size_t count, double *counts)>;

struct UnsupervisedOptions {
    uint32_t epochs = 300; // total, including those of a resumed training
    uint32_t batch = 16;
    unsigned workers = 0; // 0 = one per processor; the result does not depend on it
    double learning_rate = 1e-3;
    size_t frames = 0, validation = 0; // all frames; those of them held out for validation, at least 1
    Progress progress;
    Losses losses;
    std::function<void(const Training &)> epoch; // called after each epoch; may throw to stop. Empty: none
    Course course() const noexcept { return {Mode::unsupervised, learning_rate, 0, frames, validation, batch}; }
};

// Random initial weights of unsupervised training: normal with variance 1/inputs; biases 0.
Parameters initial_weights(const Layout &layout, uint64_t seed);

// Trains from state (done = 0: random weights) until options.epochs are done. On return and on failure state is that of
// the last complete epoch. Status::cancelled, Status::range if training diverges.
void train_unsupervised(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames,
                        Training &state);

// The network with the weights of state.
Network trained_network(const Network &network, const Training &state);

// Mean quality of the reconstructions of the validation frames.
Quality validate(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames);

} // namespace toliman::cae
