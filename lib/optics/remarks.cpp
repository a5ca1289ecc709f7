#include "optics/remarks.hpp"

#include <algorithm>
#include <cmath>

#include "base/workers.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kRough = 6; // wavelengths that show the light to a few per cent

// Expected electrons of the frame without displacement.
Buffer<double> rough_frame(const Outline &outline, const DetectorStages &detector, unsigned workers) {
    const Scene &scene = outline.scene;
    Plan plan = outline.plan;
    plan.engine = EngineKind::matrix_dft;
    if (plan.wavelengths > kRough) {
        plan.nodes = true;
        plan.wavelengths = kRough;
    }
    const Imager imager(scene, outline.pupil, plan, workers);
    Buffer<double> frame(scene.detector.rows * scene.detector.cols);
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const StarImages images = imager.images(outline.light, star, 0, Wanted());
        for (size_t i = 0; i < frame.size(); i++)
            frame[i] += images.at(0, 0)[i];
    }
    const double peak = *std::max_element(frame.begin(), frame.end());
    const double factor = scene.cadence.peak_photons > 0 && peak > 0 ? scene.cadence.peak_photons / peak : 1;
    for (double &value : frame)
        value = std::max(0.0, value) * factor; // few nodes may leave less than nothing
    detector.collect(frame);
    for (double &value : frame)
        value += detector.dark_e();
    return frame;
}

void remark_on_places(const Scene &scene, const Light &light, const Log &log) {
    const auto rows = static_cast<double>(scene.detector.rows), cols = static_cast<double>(scene.detector.cols);
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const auto &place = light.offset_px[star];
        const double outside = std::max(std::fabs(place[0]) - 0.5 * cols, std::fabs(place[1]) - 0.5 * rows);
        if (outside > 0)
            log.warn("%s: star %c stands at (%.1f, %.1f) px, outside the frame of %zu x %zu by %.1f px",
                     scene.source.c_str(), star == 0 ? 'A' : 'B', place[0], place[1], scene.detector.rows,
                     scene.detector.cols, outside);
    }
}

} // namespace

void remark(const Scene &scene, const Light &light, const Plan &plan, const Log &log) {
    const char *const source = scene.source.c_str();
    if (plan.filter.error > scene.accuracy)
        log.warn("%s: accuracy = %g: the pixel's filter is expected to be off by %.2g", source, scene.accuracy,
                 plan.filter.error);
    remark_on_places(scene, light, log);
    if (plan.orbit_px > 0)
        log.warn("%s: binary.moving: stars move by at most %.2g px along their orbit: estimators are made for time 0",
                 source, plan.orbit_px);
    if (plan.exact_frames && (scene.systematics.any() || scene.binary.moving))
        log.warn("%s: stars move too far for a series at accuracy = %g, or frames are too few for one: every frame is "
                 "propagated anew",
                 source, scene.accuracy);
    else if (plan.exact_frames)
        log.warn("%s: signal: %g px is too far for a series at accuracy = %g: every frame is propagated anew", source,
                 scene.signal.amplitude_px, scene.accuracy);
    if (plan.scale_focus_error > scene.accuracy)
        log.warn("%s: accuracy = %g: systematics: scale to first and focus to second order may be off by %.2g of the "
                 "peak",
                 source, scene.accuracy, plan.scale_focus_error);
}

void remark_beforehand(const Outline &outline, const Settings &settings) {
    const Scene &scene = outline.scene;
    remark(scene, outline.light, outline.plan, settings.log);
    if (!scene.detector.full_well_e && scene.detector.bit_depth == 0)
        return;
    const DetectorStages detector(scene);
    detector.warn(rough_frame(outline, detector, worker_count(settings.workers)), "about ", scene.source, settings.log);
}

} // namespace toliman::optics
