// Tied training: the encoder learns to be the transpose of a linear decoder that paints the whitened derivative image.
#pragma once
#include <cstdint>

#include "base/progress.hpp"
#include "cae/network.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

struct TiedOptions {
    uint32_t steps = 300;
    double learning_rate = 0.08; // rad, the most a step turns a tensor; falls linearly to 0
    Progress progress;
    Losses losses;
    Course course() const noexcept { return {Mode::tied, learning_rate, steps, 0, 0, 0}; }
};

// Whether a network can be trained so: layout flight and whitened input.
bool can_be_tied(const Layout &layout, Input input) noexcept;

// Network with random weights; where it can be trained so, with the latent scaled to px along the target.
Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed);

// A new network with the preprocessing and the seed of the given one. state is that of the last whole step, also on
// failure, and counts 0 done at first; its loss is the squared distance of the unit target and its part along the
// painted image. Status::unsupported where it cannot be tied.
Network train_tied(const Network &network, const TiedOptions &options, Training &state);

} // namespace toliman::cae
