// The figures of merit of a mask.
#pragma once
#include <limits>

#include "optics/simulator.hpp"

namespace toliman::mask {

struct Score {
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    // Cramer-Rao bounds of the separation: with the chosen nuisances free, all known, fluxes and shift free.
    double crb_px = kNone, alone_px = kNone, flux_shift_px = kNone;
    double peak_to_mean = kNone;                              // brightest pixel over mean pixel of the noise-free frame
    double light_in_frame = 0;                                // fraction of the stars' photons
    double gradient_energy = 0;                               // px^-2 (information/information.hpp)
    double radius_50_px = 0, radius_80_px = 0;                // see encircled_px
    double quantum_px = kNone, quantum_flux_shift_px = kNone; // see quantum_of; of a designed mask
};

// Simulates the scene with another mask on one thread. Without quantum bounds.
Score score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free);

// Radius about the barycentre of an image that has this fraction of its light.
double encircled_px(const Buffer<double> &light, size_t cols, double fraction);

// Smallest bounds of a pupil with any mask that only delays, without losses of light or noise but that of photons:
// all else known, and fluxes and shift free.
struct Quantum {
    double alone_px = Score::kNone, flux_shift_px = Score::kNone;
};

// electrons: of the light per photon.
Quantum quantum_of(const optics::Outline &outline, double electrons);

// The scene with a signal of amplitude 0, which is faster to simulate: the bound does not depend on the amplitude.
Scene without_signal(Scene scene);

} // namespace toliman::mask
