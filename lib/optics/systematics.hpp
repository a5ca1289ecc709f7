// Systematics of one frame (pointing, roll, scale, aberrations, flux, background), and the places of the stars.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "scene/scene.hpp"

namespace toliman::optics {

// The systematics of one frame.
struct Disturbances {
    double pointing_px[2], roll_rad, scale, flux[2], background_photons;
    std::vector<ZernikeTerm> zernikes; // in the order of Systematics::zernikes_nm
};

// Draws those of frame k: each is its rms times a normal variate of (seed, k), plus its drift times `days`.
Disturbances draw(const Systematics &systematics, uint64_t seed, uint64_t k, double days);

using Place = std::array<long double, 2>; // [x, y], px from the centre of the frame

// Place of a star from `offset` (px): its own displacement along the axis, then the roll about the frame's centre (from
// x towards y), then the pointing, then the scale about the centre.
Place place_of(const Disturbances &disturbances, const std::array<double, 2> &offset, const double *axis,
               double displacement_px) noexcept;

} // namespace toliman::optics
