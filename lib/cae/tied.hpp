// Tied training: fits the encoder to the transpose of a linear decoder whose output is the whitened derivative image.
#pragma once
#include <cstdint>

#include "base/progress.hpp"
#include "cae/network.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

struct TiedOptions {
    uint32_t steps = 300;
    double learning_rate = 0.08; // rad, largest rotation of a tensor in one step; falls linearly to 0
    Progress progress;
    Losses losses;
    Course course() const noexcept { return {Mode::tied, learning_rate, steps, 0, 0, 0}; }
};

// Whether tied training supports this network: mean pooling and whitened input.
bool can_be_tied(const Layout &layout, Input input) noexcept;

// Network with random weights. Where tied training is supported, its latent is scaled to px along the target.
Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed);

// Trains a new network with the preprocessing and seed of the given one, from state (done = 0: random weights) on. On
// return and on failure state is that of the last complete step. Its loss is 1 - cosine^2 of the decoder output and the
// target. Status::unsupported unless can_be_tied().
Network train_tied(const Network &network, const TiedOptions &options, Training &state);

// Encoders without preprocessing, for images that are whitened already; the tensors of the decoder are 0.
Parameters random_encoder(const Layout &layout, uint64_t seed);
// Trains the encoder for a target [pixels] of any norm above 0, from given weights on. Returns the cosine of gradient
// and target.
double train_encoder(const Buffer<double> &target, const TiedOptions &options, Parameters &weights);
// d latent/d image at 0 of an encoder with mean pooling and without biases: [pixels].
Buffer<double> gradient_of(const Parameters &weights);

} // namespace toliman::cae
