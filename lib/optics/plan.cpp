#include "optics/plan.hpp"

#include <algorithm>
#include <cmath>

#include "optics/nodes.hpp"
#include "optics/padded_fft.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNodeMargin = 4;     // node errors are found on a few pixels: measured 0.3 to 3 of those of all pixels
constexpr size_t kFewWavelengths = 8; // not worth fewer
constexpr size_t kLeastOrder = 2, kMostOrder = 8;

// Highest frequency of an image, in cycles per pixel.
double cutoff_of(const Pupil &pupil, const Light &light, const Grid &pixels) noexcept {
    return pupil.aperture_m * static_cast<double>(pixels.pitch_rad) / light.wavelength_m.front();
}

// A matrix Fourier transform repeats itself every N lambda/D; each star's first repetition must stay off the frame.
void refuse_aliases(const Scene &scene, const Pupil &pupil, const Light &light, const Plan &plan) {
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const double finer = static_cast<double>(plan.filter.oversampling);
    const double side[2] = {static_cast<double>(grid.cols) / finer, static_cast<double>(grid.rows) / finer};
    double farthest_px = 0;
    for (size_t star = 0; star < scene.stars.size(); star++)
        for (size_t axis = 0; axis < 2; axis++)
            farthest_px = std::max(farthest_px, side[axis] / 2 + std::fabs(light.offset_px[star][axis]));
    const double needed = std::ceil(2 * farthest_px * cutoff_of(pupil, light, plan.pixels));
    if (static_cast<double>(pupil.samples) < needed)
        fail(Status::scene, "%s: telescope.pupil_samples = %zu: must be at least %.0f, or the frame shows aliases",
             scene.source.c_str(), pupil.samples, needed);
}

// This engine samples the pupil anew at each wavelength, and takes each of the scene's.
void check_padded_fft(const Scene &scene, const Light &light, Plan &plan) {
    const Telescope &telescope = scene.telescope;
    if (telescope.mask.kind == Mask::Kind::file || !telescope.amplitude_file.empty() || !telescope.opd_file.empty())
        fail(Status::unsupported,
             "%s: telescope: the fft engine samples the pupil anew at each wavelength: it takes "
             "no mask, amplitude or OPD file",
             scene.source.c_str());
    plan.plate_scale_error = plate_scale_error(scene, sampling_grid(plan.pixels, plan.filter), light.wavelength_m);
}

void choose_wavelengths(const Scene &scene, const Pupil &pupil, const Light &light, unsigned workers, Plan &plan) {
    plan.wavelengths = plan.scene_wavelengths = light.wavelength_m.size();
    if (plan.wavelengths <= kFewWavelengths || plan.engine == EngineKind::padded_fft)
        return;
    const std::vector<double> errors = node_errors(pupil, light, plan.pixels, workers);
    for (size_t nodes = 1; nodes < std::min(errors.size(), plan.scene_wavelengths); nodes++) {
        const double error = kNodeMargin * errors[nodes];
        if (error > std::max(scene.accuracy, kRounding))
            continue;
        plan.nodes = true;
        plan.wavelengths = nodes;
        plan.spectrum_error = error;
        return;
    }
}

// Bernstein: a derivative of an image is at most 2 pi cutoff times the one before. The first term left out, against the
// signal d I1, is d^n/(n + 1)! times the n-th derivative of that.
void choose_order(const Scene &scene, const Pupil &pupil, const Light &light, Plan &plan) {
    const double turn = 2 * kPi * cutoff_of(pupil, light, plan.pixels) * scene.signal.amplitude_px;
    double error = 1;
    for (size_t order = 1; order <= kMostOrder; order++) {
        error *= turn / static_cast<double>(order + 1);
        plan.order = order;
        plan.series_error = error;
        if (order >= kLeastOrder && error <= scene.accuracy)
            return;
    }
    plan.exact_frames = true;
    plan.series_error = 0;
}

} // namespace

Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers) {
    Plan plan;
    plan.engine = engine;
    const Detector &detector = scene.detector;
    plan.pixels = {detector.rows, detector.cols, detector.pixel_scale_arcsec * 3.14159265358979323846264L / 648000};
    plan.filter = make_filter(cutoff_of(pupil, light, plan.pixels), detector.integrated, 0, scene.accuracy);
    if (engine == EngineKind::padded_fft)
        check_padded_fft(scene, light, plan);
    else
        refuse_aliases(scene, pupil, light, plan);
    choose_wavelengths(scene, pupil, light, workers, plan);
    choose_order(scene, pupil, light, plan);
    return plan;
}

} // namespace toliman::optics
