// Spiral masks, the sign of a sum of spiral cosines: draws them at random, varies them, reads and writes their JSON.
#pragma once
#include <cstdint>
#include <vector>

#include "common/json.hpp"

namespace cli {

struct SpiralTerm {
    double a, f, l, m, p; // a cos(2 pi f r + l ln r + m theta + p), r in units of the aperture's radius; m whole
};
using Terms = std::vector<SpiralTerm>;

// Random mask number k of a seed: two to six terms with at most 1 to 14 cycles along the radius (drawn too).
Terms draw_terms(uint64_t seed, uint64_t k);

// Random variation number k of the terms, with steps from reach/128 to reach.
Terms vary_terms(const Terms &terms, double reach, uint64_t seed, uint64_t k);

// The terms of a mask of a valid scene; empty if it is not a spiral.
Terms terms_of(const cJSON *mask);
std::vector<Json> json_of(const Terms &terms);

} // namespace cli
