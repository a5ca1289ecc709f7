// Random spiral masks: the sign of a sum of spiral cosines.
#pragma once
#include <vector>

#include "scene/scene.hpp"

namespace toliman::mask {

// Terms of random mask number k of a seed: two to six, with at most 1 to 14 cycles along the radius (drawn too).
std::vector<SpiralTerm> draw_terms(uint64_t seed, uint64_t k);

} // namespace toliman::mask
