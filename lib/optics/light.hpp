// The light of the stars: sampled wavelengths, photons at each, and where the stars stand.
#pragma once
#include <array>
#include <vector>

#include "optics/scene.hpp"

namespace toliman::optics {

using Offsets = std::array<std::array<double, 2>, 2>; // [star][x, y], px

struct Light {
    std::vector<double> wavelength_m;
    std::array<std::vector<double>, 2> photons; // of A and B at each wavelength, whole star; B empty without one
    Offsets offset_px = {};                     // at time 0
    double axis[2] = {1, 0};                    // unit vector of a positive displacement of the moving star
    double separation_px = 0;
};

// Photons are relative (scaled later to the peak) or absolute, as the cadence says.
Light make_light(const Scene &scene);

// Unit vector of a positive displacement of the star that moves, with the stars there.
std::array<double, 2> axis_of(const Scene &scene, const Offsets &offsets) noexcept;

// Where the stars of that light stand `days` after time 0: on their orbit if the scene has one, else as at time 0. The
// scene's centre stands on the frame's axis at any time.
Offsets offsets_at(const Scene &scene, const Light &light, double days) noexcept;

// Multiplies all photons.
void scale_light(Light &light, double factor) noexcept;

} // namespace toliman::optics
