// What a frame can tell at best: Cramer-Rao bounds of the separation.
#pragma once
#include "optics/images.hpp"

namespace toliman::optics {

// Standard deviations in px; infinity where the separation cannot be told from what is free.
struct Bounds {
    double alone = 0;      // all else known
    double flux_shift = 0; // both fluxes and the common shift free
    double marginal = 0;   // all eight nuisances free
    double projected = 0;  // exactly the scene's preprocess.project free
};

Bounds bound(const Scene &scene, const Images &images);

// The derivative image of one nuisance.
const Buffer<double> &image_of(const Images &images, Nuisance nuisance) noexcept;

} // namespace toliman::optics
