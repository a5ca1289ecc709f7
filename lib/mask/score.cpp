// Method: a mask is scored by the simulation of its scene, whose Cramer-Rao bound is the smallest standard deviation
// that any estimator can reach from the frame (information/information.cpp): no estimator has to be trained for each
// mask. No measurement of a photon tells more of the direction u of its star than the quantum Fisher information of its
// wave in the pupil: with the pupil coordinate x along u, weighted by the transmitted light,
//     Q = 4 (2 pi / lambda)^2 Var(x)
// per photon, whatever the phases in the pupil. The separation of two stars, each of unknown place, has the variance
// 1/Q_A + 1/Q_B. Reference: Helstrom 1976, Quantum Detection and Estimation Theory, chapter 8.
#include "mask/score.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/constants.hpp"
#include "information/information.hpp"

namespace toliman::mask {

namespace {

double total(const std::vector<double> &photons) {
    return std::accumulate(photons.begin(), photons.end(), 0.0);
}

// Variance (m^2) of the pupil coordinate along the separation, weighted by the transmitted light.
double pupil_variance_m2(const optics::Outline &outline) {
    const size_t n = outline.pupil.samples;
    const double cell = outline.scene.telescope.aperture_m / static_cast<double>(n);
    double sum = 0, first = 0, second = 0;
    for (size_t i = 0; i < n * n; i++) {
        const double amplitude = outline.pupil.amplitude[i], weight = amplitude * amplitude;
        const size_t row = i / n, col = i % n;
        const double x = cell * (static_cast<double>(col) * outline.light.axis[0] +
                                 static_cast<double>(row) * outline.light.axis[1]);
        sum += weight;
        first += weight * x;
        second += weight * x * x;
    }
    return second / sum - first / sum * (first / sum);
}

} // namespace

Score score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free) {
    optics::Settings settings;
    settings.workers = 1;
    scene.telescope.mask = mask;
    optics::Outline outline = optics::outline_of(std::move(scene), settings);
    const optics::Imager imager(outline.scene, outline.pupil, outline.plan, settings.workers);
    const optics::DetectorStages detector(outline.scene);
    const optics::Images images(outline.scene, outline.pupil, imager, outline.plan, detector, outline.light, {}, 1);
    const Buffer<double> &light = images.both();
    Score score;
    score.crb_px = information::bound_with(images, free);
    score.alone_px = information::bound_with(images, {});
    score.flux_shift_px = information::bound_with(images, information::fluxes_and_shift(outline.scene));
    score.peak_to_mean = images.peak_photons() / images.total_photons() * static_cast<double>(light.size());
    score.light_in_frame = images.total_photons() / (total(outline.light.photons[0]) + total(outline.light.photons[1]));
    score.gradient_energy = information::gradient_energy(images);
    score.radius_50_px = encircled_px(light, outline.plan.pixels.cols, 0.5);
    score.radius_80_px = encircled_px(light, outline.plan.pixels.cols, 0.8);
    return score;
}

double encircled_px(const Buffer<double> &light, size_t cols, double fraction) {
    double sum = 0, x = 0, y = 0;
    for (size_t i = 0; i < light.size(); i++) {
        const size_t row = i / cols, col = i % cols;
        sum += light[i];
        x += light[i] * static_cast<double>(col);
        y += light[i] * static_cast<double>(row);
    }
    std::vector<std::pair<double, double>> rings; // square of the radius, light
    for (size_t i = 0; i < light.size(); i++) {
        const size_t row = i / cols, col = i % cols;
        const double dx = static_cast<double>(col) - x / sum, dy = static_cast<double>(row) - y / sum;
        rings.emplace_back(dx * dx + dy * dy, light[i]);
    }
    std::sort(rings.begin(), rings.end());
    double within = 0;
    for (const auto &[square, value] : rings) {
        within += value;
        if (within >= fraction * sum)
            return std::sqrt(square);
    }
    return std::sqrt(rings.back().first);
}

Quantum quantum_of(const optics::Outline &outline, double electrons) {
    const double pixel_rad = outline.scene.detector.pixel_scale_arcsec * kPi / 648000;
    const double variance = pupil_variance_m2(outline);
    double information[2] = {0, 0}; // px^-2
    for (size_t s = 0; s < 2; s++)
        for (size_t k = 0; k < outline.light.photons[s].size(); k++) { // none of B in a single star
            const double rate = 2 * kPi * pixel_rad / outline.light.wavelength_m[k];
            information[s] += 4 * rate * rate * variance * electrons * outline.light.photons[s][k];
        }
    return {1 / std::sqrt(information[outline.scene.signal.star]), std::sqrt(1 / information[0] + 1 / information[1])};
}

Scene without_signal(Scene scene) {
    if (scene.signal.kind == Signal::Kind::none)
        return scene;
    const size_t star = scene.signal.star;
    scene.signal = {};
    scene.signal.kind = Signal::Kind::sinusoid;
    scene.signal.star = star;
    scene.signal.period_days = 1;
    return scene;
}

} // namespace toliman::mask
