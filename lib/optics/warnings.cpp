#include "optics/warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/workers.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kRoughWavelengths = 6; // wavelengths that give the image to a few per cent

// Expected electrons of the reference frame, to a few per cent.
Buffer<double> rough_frame(const Outline &outline, const DetectorStages &detector, unsigned workers) {
    const Scene &scene = outline.scene;
    Plan plan = outline.plan;
    plan.engine = EngineKind::matrix_dft;
    if (plan.wavelengths > kRoughWavelengths && !outline.light.is_dispersed()) {
        plan.nodes = true;
        plan.wavelengths = kRoughWavelengths;
    }
    const Imager imager(scene, outline.pupil, plan, workers);
    Buffer<double> frame(scene.detector.rows * scene.detector.cols);
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const StarImages images = imager.images(outline.light, star, 0, ImageRequest());
        for (size_t i = 0; i < frame.size(); i++)
            frame[i] += images.at(0, 0)[i];
    }
    const double peak = *std::max_element(frame.begin(), frame.end());
    const double factor = scene.cadence.peak_photons > 0 && peak > 0 ? scene.cadence.peak_photons / peak : 1;
    for (double &value : frame)
        value = std::max(0.0, value) * factor; // with few nodes faint pixels may be negative
    detector.collect(frame);
    for (double &value : frame)
        value += detector.dark_e();
    return frame;
}

// Cells must follow the wavefront, and point pixels the image: the light that is sampled is wrong otherwise.
void warn_of_sampling(const Scene &scene, const Pupil &pupil, const Light &light, const Plan &plan, const Log &log) {
    const auto [shortest, longest] = std::minmax_element(light.wavelength_m.begin(), light.wavelength_m.end());
    const char *const source = scene.source.c_str();
    if (pupil.steepest_m > 0.5 * *shortest)
        log.warn(
            "%s: telescope.aberrations: the OPD changes by up to %.3g nm from one pupil cell to the next, more than "
            "half a wavelength: the image is wrong: pupil_samples must be at least %.0f",
            source, 1e9 * pupil.steepest_m,
            std::ceil(2 * pupil.steepest_m / *shortest * static_cast<double>(pupil.samples)));
    const double steps = static_cast<double>(plan.pixels.pitch_rad) * pupil.aperture_m / *longest;
    if (!scene.detector.integrated && steps > 1)
        log.warn(
            "%s: detector.pixel = \"point\": the image is sampled every %.3g lambda/D: the light of a frame depends "
            "on where its stars are in their pixels: give pixel \"integrated\"",
            source, steps);
}

// Behind a grating, of all wavelengths of a star the nearest to the frame.
void warn_outside_frame(const Scene &scene, const Light &light, const Log &log) {
    const auto rows = static_cast<double>(scene.detector.rows), cols = static_cast<double>(scene.detector.cols);
    for (size_t star = 0; star < scene.stars.size(); star++) {
        double x = 0, y = 0, outside = std::numeric_limits<double>::infinity();
        for (const double wavelength : light.wavelength_m) {
            const auto moved = light.dispersed_px(wavelength);
            const double at_x = light.offset_px[star][0] + moved[0], at_y = light.offset_px[star][1] + moved[1],
                         beyond = std::max(std::fabs(at_x) - 0.5 * cols, std::fabs(at_y) - 0.5 * rows);
            if (beyond < outside) {
                x = at_x;
                y = at_y;
                outside = beyond;
            }
        }
        if (outside > 0)
            log.warn("%s: star %c is at (%.1f, %.1f) px%s, outside the frame of %zu x %zu by %.1f px",
                     scene.source.c_str(), star == 0 ? 'A' : 'B', x, y,
                     light.is_dispersed() ? " in the order of detector.sidelobe" : "", scene.detector.rows,
                     scene.detector.cols, outside);
    }
}

// The image of a continuous spectrum is a sum of those of its samples. These are too far apart if their distance is a
// period of a frequency that the optics pass: lambda/D.
void warn_of_dispersion(const Scene &scene, const Light &light, const Log &log) {
    if (!scene.detector.sidelobe || !scene.band || scene.band->steps == 0)
        return;
    const double step = (scene.band->max_nm - scene.band->min_nm) / static_cast<double>(scene.band->steps),
                 most =
                     light.wavelength_m.front() * 1e9 * scene.detector.sidelobe->period_m / scene.telescope.aperture_m;
    if (step > most)
        log.warn("%s: band.step_nm = %.3g: must be at most %.2g nm, or the spectrum in detector.sidelobe is a row of "
                 "separate images",
                 scene.source.c_str(), step, most);
}

const char *why_propagated(const Scene &scene, const Plan &plan) noexcept {
    if (scene.systematics.changes_optics())
        return "focus, aberrations or scale differ from frame to frame";
    if (plan.engine == EngineKind::padded_fft)
        return "the padded FFT has another plate scale on the grid of an interpolation";
    return plan.atlas.oversampling == 0 ? "interpolation would exceed the rounding of the images"
                                        : "a star is too far from the frame for an interpolation";
}

// A model that was incomplete for the frames of its calibration is incomplete for all others.
void warn_of_calibration(const Scene &scene, const Log &log) {
    if (!scene.calibration || !scene.calibration->stated)
        return;
    const char *const source = scene.source.c_str();
    const auto &[chi_square, sigma, largest, verdict] = scene.calibration->goodness;
    if (verdict == GoodnessVerdict::unknown)
        log.warn("%s: its calibration did not end: values may be wrong by more than their standard deviations", source);
    else if (verdict == GoodnessVerdict::too_good)
        log.warn("%s: its calibration is too good: chi-square %.6g +- %.2g: variances or the unit of the frames are "
                 "wrong, and so are all standard deviations",
                 source, chi_square, sigma);
    else if (!scene.calibration->complete)
        log.warn("%s: its calibration is incomplete: chi-square %.6g +- %.2g, %s: values may be wrong by more than "
                 "their standard deviations",
                 source, chi_square, sigma, name_of(verdict));
}

} // namespace

void warn_of_plan(const Scene &scene, const Pupil &pupil, const Light &light, const Plan &plan, const Log &log) {
    const char *const source = scene.source.c_str();
    warn_of_calibration(scene, log);
    if (plan.filter.error > scene.accuracy)
        log.warn("%s: accuracy = %g: the pixel filter's expected error is %.2g", source, scene.accuracy,
                 plan.filter.error);
    warn_of_sampling(scene, pupil, light, plan, log);
    warn_outside_frame(scene, light, log);
    warn_of_dispersion(scene, light, log);
    if (plan.orbit_px > 0)
        log.warn("%s: binary.moving: the stars move by up to %.2g px along their orbit: only the fit and a bank of "
                 "networks follow them, other estimators are made for time 0",
                 source, plan.orbit_px);
    if (plan.frames == Frames::atlas && plan.atlas.error > scene.accuracy)
        log.warn("%s: accuracy = %g: the expected error of the interpolated stars is %.2g", source, scene.accuracy,
                 plan.atlas.error);
    if (plan.frames == Frames::propagation)
        log.warn("%s: accuracy = %g: every frame is re-propagated: %s", source, scene.accuracy,
                 why_propagated(scene, plan));
}

void warn_before_images(const Outline &outline, const Settings &settings) {
    const Scene &scene = outline.scene;
    warn_of_plan(scene, outline.pupil, outline.light, outline.plan, settings.log);
    if (!scene.detector.full_well_e && scene.detector.bit_depth == 0)
        return;
    const DetectorStages detector(scene);
    detector.warn(rough_frame(outline, detector, worker_count(settings.workers)), "about ", scene.source, settings.log);
}

} // namespace toliman::optics
