// Fluxes of stars from their magnitudes in a photometric band.
#pragma once
#include "scene/scene.hpp"

namespace toliman::optics {

// Sets photons_per_s of the stars that have a magnitude in a band and no photons_per_s yet. area_m2: of the open pupil.
// Status::scene for a spectrum that does not cover the band, and for a flux out of range.
void set_fluxes(Scene &scene, double area_m2);

} // namespace toliman::optics
