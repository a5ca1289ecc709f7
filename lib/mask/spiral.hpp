// Spiral masks, the sign of a sum of spiral cosines: draws them at random, varies them, and writes them as JSON.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace toliman::mask {

using Terms = std::vector<SpiralTerm>;

// Random mask number k of a seed: two to six terms with at most 1 to 14 cycles along the radius (drawn too).
Terms draw_terms(uint64_t seed, uint64_t k);

// Random variation number k of the terms, with steps from reach/128 to reach.
Terms vary_terms(const Terms &terms, double reach, uint64_t seed, uint64_t k);

// A spiral mask, or one of a binary file, as the group "mask" of a scene, on one line; every number is read again as
// the same bits.
std::string json_of(const Mask &mask);

} // namespace toliman::mask
