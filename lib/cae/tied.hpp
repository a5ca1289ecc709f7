// Tied training: the encoder learns to be the transpose of a linear decoder that paints the whitened derivative image.
#pragma once
#include <cstdint>

#include "base/progress.hpp"
#include "cae/network.hpp"

namespace toliman::cae {

struct TrainOptions {
    uint32_t steps = 300;
    double learning_rate = 0.08; // rad, the most a step turns a tensor; falls linearly to 0
    Progress progress;
};

struct Training {
    double loss;   // squared distance of the unit target and its part along the painted image
    double cosine; // of d latent/d residual and the target: the predicted efficiency
};

// Network with random weights; where it can be trained so, with the latent scaled to px along the target.
Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed);

// A new network with the preprocessing and the seed of the given one. Status::unsupported for another layout than
// flight and an input that is not whitened.
Network train_tied(const Network &network, const TrainOptions &options, Training &report);

} // namespace toliman::cae
