// Method: a mask is scored by the simulation of its scene, whose Cramer-Rao bound is
//     sigma = 1 / |(dI/dd) / sqrt(V)|,
// with I the expected frame, V its variance and d the separation (optics/information.cpp). It is the smallest standard
// deviation that any estimator can reach, so that no estimator has to be trained for each mask. The coarse scene has
// at most six wavelengths and half the pupil samples: until the full scene confirms the best masks only their order
// matters.
#include "mask/score.hpp"

#include <algorithm>
#include <numeric>

namespace toliman::mask {

namespace {

constexpr size_t kCoarseSteps = 5, kFewestSamples = 8;

double total(const std::vector<double> &photons) {
    return std::accumulate(photons.begin(), photons.end(), 0.0);
}

// Calls work with the images of the scene with another mask, computed on one thread, and with its light.
template <class Work> auto with_images(Scene scene, const Mask &mask, Work work) {
    optics::Settings settings;
    settings.workers = 1;
    scene.telescope.mask = mask;
    optics::Outline outline = optics::outline_of(std::move(scene), settings);
    const optics::Imager imager(outline.scene, outline.pupil, outline.plan, settings.workers);
    const optics::DetectorStages detector(outline.scene);
    const optics::Images images(outline.scene, outline.pupil, imager, outline.plan, detector, outline.light, {}, 1);
    return work(images, outline.light);
}

// With too few samples the image aliases, and files of the pupil have a fixed size.
bool can_be_simulated(const Scene &scene, const Mask &mask) {
    try {
        score_of(scene, mask);
        return true;
    } catch (const Error &error) {
        if (error.status() == Status::scene || error.status() == Status::format)
            return false;
        throw;
    }
}

} // namespace

Score score_of(const optics::Images &images, const optics::Light &light, const std::vector<Parameter> &free) {
    const double mean = images.total_photons() / static_cast<double>(images.both().size());
    return {optics::bound_with(images, free), images.peak_photons() / mean,
            images.total_photons() / (total(light.photons[0]) + total(light.photons[1])), 0};
}

// Only what a score needs: the stars' images, and the first derivative by the displacement.
Score score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free) {
    return with_images(std::move(scene), mask, [&](const optics::Images &images, const optics::Light &light) {
        return score_of(images, light, free);
    });
}

Score full_score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free) {
    return with_images(std::move(scene), mask, [&](const optics::Images &images, const optics::Light &light) {
        Score score = score_of(images, light, free);
        score.gradient_energy = optics::gradient_energy(images);
        return score;
    });
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

Scene coarse(Scene scene, const Mask &trial) {
    if (scene.band)
        scene.band->steps = std::min(scene.band->steps, kCoarseSteps);
    Scene half = scene;
    half.telescope.pupil_samples /= 2;
    return half.telescope.pupil_samples >= kFewestSamples && can_be_simulated(half, trial) ? half : scene;
}

} // namespace toliman::mask
