// Method: the variates are counter-based, keyed by (seed, k): frame k has the same systematics in any order of
// evaluation. Places are formed in long double: a displacement of 1e-10 px added to 40 px in double would be off by
// 7e-15 px.
#include "optics/systematics.hpp"

#include <cmath>

#include "kernels/poisson.hpp"
#include "kernels/zernike.hpp"

namespace toliman::optics {

namespace {

constexpr int kFocus = 4; // Noll's number

// Numbers of the variates: append new ones. That of another Zernike polynomial is first_zernike plus its Noll index.
enum Draw : size_t {
    pointing_x,
    pointing_y,
    roll,
    scale,
    focus,
    flux_a,
    flux_b,
    background,
    first_zernike,
    draws = first_zernike + kernels::kLargestNoll + 1
};

} // namespace

Disturbances draw(const Systematics &systematics, uint64_t seed, uint64_t k, double days) {
    double normals[draws];
    kernels::poisson_kernels().gaussian(draws, 0, {seed, k, kernels::kStreamSystematics}, normals);
    const auto value = [&](const Disturbance &disturbance, size_t which) {
        return disturbance.rms * normals[which] + disturbance.drift_per_day * days;
    };
    Disturbances drawn = {{value(systematics.pointing_px, pointing_x), value(systematics.pointing_px, pointing_y)},
                          value(systematics.roll_rad, roll),
                          value(systematics.scale, scale),
                          {value(systematics.flux, flux_a), value(systematics.flux, flux_b)},
                          value(systematics.background_photons, background),
                          {}};
    for (const auto &[noll, rms_nm] : systematics.zernikes_nm) {
        const size_t which = noll == kFocus ? size_t{focus} : first_zernike + static_cast<size_t>(noll);
        drawn.zernikes.push_back({noll, 1e-9 * value(rms_nm, which)});
    }
    return drawn;
}

Place place_of(const Disturbances &disturbances, const std::array<double, 2> &offset, const double *axis,
               double displacement_px) noexcept {
    const double sine = std::sin(disturbances.roll_rad), half = std::sin(0.5 * disturbances.roll_rad);
    const long double cosine = 1 - 2 * static_cast<long double>(half) * half; // accurate at small rolls
    const long double wobble = displacement_px, stretch = 1 + static_cast<long double>(disturbances.scale);
    const long double x = offset[0] + wobble * axis[0], y = offset[1] + wobble * axis[1];
    return {stretch * (disturbances.pointing_px[0] + cosine * x - sine * y),
            stretch * (disturbances.pointing_px[1] + cosine * y + sine * x)};
}

} // namespace toliman::optics
