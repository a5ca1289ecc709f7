// The light of the stars: sampled wavelengths, photons at each, and where the stars stand.
#pragma once
#include <vector>

#include "optics/scene.hpp"

namespace toliman::optics {

struct Light {
    std::vector<double> wavelength_m;
    std::vector<double> photons[2]; // of A and B at each wavelength, whole star; B empty without one
    double offset_px[2][2] = {};    // [star][x, y]
    double axis[2] = {1, 0};        // unit vector of a positive displacement of the moving star
    double separation_px = 0;
};

// Photons are relative (scaled later to the peak) or absolute, as the cadence says.
Light make_light(const Scene &scene);

// Multiplies all photons.
void scale_light(Light &light, double factor) noexcept;

} // namespace toliman::optics
