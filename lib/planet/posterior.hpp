// Samples of the posterior of a candidate.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "planet/lattice.hpp"

namespace toliman::planet {

struct PosteriorSample {
    Planet planet;
    double jitter;
};

// Draws `count` samples of equal weight, in random order.
std::vector<PosteriorSample> draw_samples(const Problem &problem, const Lattice &lattice, size_t count, uint64_t seed,
                                          unsigned threads);

// The most probable planet at the best node of the lattice.
Planet best_of(const Problem &problem, const Lattice &lattice);

// Points of the sorted values at the shares 0.16, 0.5 and 0.84.
using Interval = std::array<double, 3>;
Interval interval_of(std::vector<double> values);

// That of the jitter.
Interval jitter_of(const std::vector<PosteriorSample> &samples);

} // namespace toliman::planet
