// The light of the stars: sampled wavelengths, photons at each, and the stars' positions on the detector.
#pragma once
#include <array>
#include <vector>

#include "scene/scene.hpp"

namespace toliman::optics {

using Offsets = std::array<std::array<double, 2>, 2>; // [star][x, y], px

struct Light {
    std::vector<double> wavelength_m;
    // Of A and B at each wavelength, over an infinite image; B empty for a single star. Electrons, if the scene counts
    // them or has a file of quantum efficiencies.
    std::array<std::vector<double>, 2> photons;
    std::vector<double> qe; // that photons contains, at each wavelength; empty without a file
    std::array<double, 2> throughput = {1, 1}, efficiency = {1, 1}; // means over the photons of A and B
    Offsets offset_px = {};                                         // from the optical axis at time 0
    double dispersion[2] = {0, 0};                                  // of a sidelobe: px per m of wavelength, of
    double centre_m = 0;                                            // which this one is at the stars' offsets
    double axis[2] = {1, 0}; // unit vector of a positive displacement of the moving star
    double separation_px = 0;

    double before_qe(size_t star, size_t wavelength) const noexcept {
        return qe.empty() ? photons[star][wavelength] : photons[star][wavelength] / qe[wavelength];
    }
    bool is_dispersed() const noexcept { return dispersion[0] != 0 || dispersion[1] != 0; }
    // Displacement [x, y] of the light of a wavelength, px.
    std::array<double, 2> dispersed_px(double wavelength) const noexcept {
        return {dispersion[0] * (wavelength - centre_m), dispersion[1] * (wavelength - centre_m)};
    }
};

// Photons per frame are absolute if the cadence gives an exposure, else relative, to be scaled to the peak later.
Light make_light(const Scene &scene);

// Photons of a star before the quantum efficiency of a file.
double photons_before_qe(const Light &light, size_t star) noexcept;

// Unit vector of a positive displacement of the moving star, with the stars at these offsets: along the separation,
// away from the other star; (1, 0) for a single star.
std::array<double, 2> axis_of(const Scene &scene, const Offsets &offsets) noexcept;

// Offsets of the stars in a frame `days` after time 0: means over the exposure of what the observer sees, if the scene
// has one; on the orbit if the stars move; otherwise those of time 0. The scene's centre (barycentre of the light, A or
// B) is on the optical axis at all times. Status::range where the observer file has no state.
Offsets offsets_at(const Scene &scene, const Light &light, double days);
// The same without an observer, whose aberration in a low orbit varies by 1e-3 px every 97 minutes.
Offsets unobserved_offsets_at(const Scene &scene, const Light &light, double days) noexcept;
// On their orbit, if the scene has one.
Offsets orbit_offsets_at(const Scene &scene, const Light &light, double days) noexcept;

// Light of a frame, relative to that of the scene: its time on target, if the scene has windows.
double relative_light_at(const Scene &scene, double days);

// Multiplies all photons.
void scale_light(Light &light, double factor) noexcept;

} // namespace toliman::optics
