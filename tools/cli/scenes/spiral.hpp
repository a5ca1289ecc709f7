// Spiral masks: sign of a sum of spiral cosines; drawn at random, varied, read from a scene and written as JSON.
#pragma once
#include <cstdint>
#include <vector>

#include "common/json.hpp"

namespace cli {

struct SpiralTerm {
    double a, f, l, m, p; // a cos(2 pi f r + l ln r + m theta + p), r in units of the aperture's radius; m whole
};
using Terms = std::vector<SpiralTerm>;

// Random mask number k of a seed, of two to six terms: of any coarseness, from one to 14 cycles along the radius.
Terms draw_terms(uint64_t seed, uint64_t k);

// Random neighbour number k of terms: small steps and large ones, up to `reach`.
Terms vary_terms(const Terms &terms, double reach, uint64_t seed, uint64_t k);

// Terms of a mask of a (valid) scene; none if it is no spiral.
Terms terms_of(const cJSON *mask);
JsonTree json_of(const Terms &terms);

} // namespace cli
