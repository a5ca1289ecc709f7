// The chapter's training: the network learns to give its own input back, mean squared error, no prior.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/progress.hpp"
#include "cae/network.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

// Fills counts [count][rows][cols] with frames first, first + 1, ...; fails by an Error.
using FrameSource = std::function<void(size_t first, size_t count, double *counts)>;

struct UnsupervisedOptions {
    uint32_t epochs = 300; // in all
    uint32_t batch = 16;
    unsigned workers = 0; // 0 = one a processor; the same bits for any number
    double learning_rate = 1e-3;
    size_t frames = 0, validation = 0; // of all frames; of them kept back from training, at least 1
    Progress progress;
    Losses losses;
    Course course() const noexcept { return {Mode::unsupervised, learning_rate, 0, frames, validation, batch}; }
};

// Random weights of a network before unsupervised training: normal, of variance 1/inputs; no biases.
Parameters initial_weights(uint64_t seed);

// Epochs from state on until options.epochs are done; state is that of the last whole epoch, also on failure, and
// counts 0 done at first. Status::cancelled, Status::range when training diverges.
void train_unsupervised(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames,
                        Training &state);

// The network with the weights of state.
Network trained_network(const Network &network, const Training &state);

// Means over the frames kept back.
Quality validate(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames);

} // namespace toliman::cae
