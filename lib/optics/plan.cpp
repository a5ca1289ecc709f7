// Method: each approximation is the cheapest whose predicted error is within the scene's accuracy.
//   wavelengths   the fewest Chebyshev nodes in 1/lambda, by node_errors() (nodes.cpp), computed with every other pupil
//                 sample where these suffice. All of a sidelobe, whose wavelengths are at different places.
//   expansion     an image has no spatial frequency above f_c = D p / lambda_min cycles per pixel, p the pixel scale.
//                 By Bernstein's inequality max |I_(n+1)| <= (2 pi f_c)^n max |I_1|: the first omitted term of the
//                 expansion of order n in a displacement d, relative to the signal d I_1, is at most
//                 (2 pi f_c d)^n / (n + 1)!. Orders 2 to 8.
//   atlas         with systematics, an orbit, or a displacement beyond the expansion, stars are interpolated: the
//                 fewest samples per pixel, then taps (atlas.cpp). Frames are propagated where their optics differ,
//                 where the accuracy is below rounding, where the samples would not fit in memory, and by the padded
//                 FFT, whose plate scale depends on the grid.
//   pixel         the shortest filter (pixel.cpp).
//   pupil         the scene's own sampling; its error is predicted but not held to the accuracy.
// The predictions are bounds or estimates, tested against the true errors within a factor of 20 on twelve scenes.
#include "optics/plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/constants.hpp"
#include "optics/nodes.hpp"
#include "optics/padded_fft.hpp"
#include "optics/reach.hpp"
#include "scene/geometry.hpp"
#include "scene/instrument.hpp"

namespace toliman::optics {

namespace {

// node_errors() samples few pixels: measured 0.3 to 3 times the error over all pixels.
constexpr double kNodeErrorMargin = 4;
constexpr size_t kMinWavelengths = 8;   // nodes are not worthwhile for fewer
constexpr double kGreyOffset = 0.2;     // cells, upper estimate of the offset of a grey cell's centroid
constexpr double kWorstPixelSigmas = 4; // standard deviations of the worst pixel
constexpr size_t kMinOrder = 2, kMaxOrder = 8;
constexpr size_t kFewestTaps = 4;
constexpr double kMaxAtlasCutoff = 0.3; // cycles per sample; the filter that divides by the window is short up to here
constexpr double kAliasMargin = 40;     // of slopes: measured 22 to 31 times the largest alias
constexpr double kFilterShare = 0.25;   // of the accuracy, for the filter of an atlas
constexpr double kPathShare = 1e-3;     // of the accuracy, for the path of a smear; it costs a node or two
constexpr double kAtlasMargin = 1;      // px beyond the reach of the stars
constexpr size_t kMostAtlasSamples = size_t{1} << 26; // of a star

// A pupil for estimates has at least kFewestRoughSamples samples and kRoughSampleMargin times those needed to avoid
// aliases. Measured on 137 scenes: its peak is within 7 %, and the errors of nodes are 0.8 to 1.5 times those of the
// whole pupil.
constexpr double kFewestRoughSamples = 128, kRoughSampleMargin = 1.5;

// Largest angle, in units of the pitch, of a displacement by one pixel: the largest singular value of the grid's map.
double longest_pixel(const Grid &grid) noexcept {
    const auto a = static_cast<double>(grid.u_x), b = static_cast<double>(grid.v_x), c = static_cast<double>(grid.v_y);
    return 0.5 * (std::hypot(a + c, b) + std::hypot(a - c, b));
}

// Highest frequency of an image, in cycles per pixel.
double cutoff_of(const Pupil &pupil, const Light &light, const Grid &pixels) noexcept {
    return pupil.aperture_m * static_cast<double>(pixels.pitch_rad) / light.wavelength_m.front() *
           longest_pixel(pixels);
}

// The discrete transform is periodic: images repeat every N lambda/D (matrix DFT) or every side of the padded array
// (FFT). Every pixel must be nearer to a star than to any of its aliases, wherever the star moves. Returns the fewest
// samples with which it is.
double refuse_aliases(const Scene &scene, const Pupil &pupil, const Light &farthest, const Plan &plan) {
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const auto finer = static_cast<double>(plan.filter.oversampling);
    const double half[2] = {static_cast<double>(grid.cols) / finer / 2, static_cast<double>(grid.rows) / finer / 2};
    const bool padded = plan.engine == EngineKind::padded_fft;
    const double px_per_sample =
        0.5 / cutoff_of(pupil, farthest, plan.pixels); // that one more pupil sample adds to half a period
    const double most_px = padded ? 0.5 * static_cast<double>(padded_side(grid)) / finer
                                  : px_per_sample * static_cast<double>(kMostPupilSamples);
    const char *const source = scene.source.c_str();
    const std::array<double, 2> first = farthest.dispersed_px(farthest.wavelength_m.front()),
                                last = farthest.dispersed_px(farthest.wavelength_m.back());
    double reach_px = 0;
    for (size_t star = 0; star < scene.stars.size(); star++)
        for (size_t axis = 0; axis < 2; axis++) {
            const double position = std::fabs(farthest.offset_px[star][axis]) +
                                    std::max(std::fabs(first[axis]), std::fabs(last[axis])),
                         reach = half[axis] + position;
            reach_px = std::max(reach_px, reach);
            if (reach > most_px && position > half[axis] && most_px > 2 * half[axis])
                fail(Status::scene,
                     "%s: {binary}: star %c is outside the frame of %zu x %zu by %.0f px: must be at most %.0f px, or "
                     "the frame shows aliases of its image",
                     source, star == 0 ? 'A' : 'B', plan.pixels.rows, plan.pixels.cols, position - half[axis],
                     most_px - 2 * half[axis]);
        }
    const double needed = std::ceil(reach_px / px_per_sample);
    if (!padded && static_cast<double>(pupil.samples) < needed)
        fail(Status::scene, "%s: {telescope.pupil_samples} = %zu: must be at least %.0f, or the frame shows aliases%s",
             source, pupil.samples, needed,
             needed > static_cast<double>(kMostPupilSamples)
                 ? "; the maximum is 2048: reduce detector.shape or detector.pixel_scale_arcsec"
                 : "");
    return needed;
}

// The pupil for estimates of images: every other cell, if these keep aliases well outside the frame and resolve a mask.
Pupil pupil_for_estimates(const Pupil &pupil, double needed) {
    const double fewest = std::max(kFewestRoughSamples, kRoughSampleMargin * needed);
    return static_cast<double>(pupil.samples) >= 2 * fewest ? halved(pupil) : pupil;
}

// The padded FFT resamples the pupil at each wavelength and propagates each of the scene's wavelengths.
void check_padded_fft(const Scene &scene, const Light &light, Plan &plan) {
    const Telescope &telescope = scene.telescope;
    if (telescope.mask.kind == Mask::Kind::file || !telescope.amplitude_file.empty() || !telescope.opd_file.empty())
        fail(Status::unsupported,
             "%s: {telescope}: the fft engine resamples the pupil at each wavelength: mask, amplitude and OPD files "
             "are not supported",
             scene.source.c_str());
    if (scene.detector.scale_anisotropy != 0 || scene.detector.shear != 0)
        fail(Status::unsupported,
             "%s: {detector}: the fft engine has square pixels: scale_anisotropy and shear are not supported",
             scene.source.c_str());
    if (scene.detector.sidelobe)
        fail(Status::unsupported, "%s: {detector.sidelobe}: not supported by the fft engine", scene.source.c_str());
    if (scene.systematics.scale.any())
        fail(Status::unsupported,
             "%s: {systematics.scale_rms}: the fft engine rounds the plate scale of each wavelength: not supported",
             scene.source.c_str());
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const size_t most = embedded_samples(scene, grid, 1 / light.wavelength_m.front());
    if (most > padded_side(grid))
        fail(Status::scene,
             "%s: {detector.pixel_scale_arcsec} = %g: must be smaller: the fft engine would need %zu pupil samples in "
             "an array of %zu",
             scene.source.c_str(), scene.detector.pixel_scale_arcsec, most, padded_side(grid));
    plan.fft_side = padded_side(grid);
    plan.fft_cells[0] = embedded_samples(scene, grid, 1 / light.wavelength_m.back());
    plan.fft_cells[1] = most;
    plan.plate_scale_errors = plate_scale_errors(scene, grid, light.wavelength_m);
}

void choose_wavelengths(const Scene &scene, const Pupil &pupil, const Light &light, double peak, unsigned workers,
                        Plan &plan) {
    plan.wavelengths = plan.scene_wavelengths = light.wavelength_m.size();
    // An accuracy below rounding means: no approximation at all.
    if (plan.wavelengths <= kMinWavelengths || plan.engine == EngineKind::padded_fft || scene.accuracy < kRounding ||
        light.is_dispersed())
        return;
    if (!(peak > 0)) // spectral lines may cancel in the rough image
        return;
    const Grid widest = {plan.pixels.rows, plan.pixels.cols, plan.pixels.pitch_rad * longest_pixel(plan.pixels)};
    const std::vector<double> errors = node_errors(pupil, light, widest, workers);
    for (size_t nodes = 1; nodes < std::min(errors.size(), plan.scene_wavelengths); nodes++) {
        const double error = kNodeErrorMargin * errors[nodes] / peak;
        if (!(error <= scene.accuracy))
            continue;
        plan.nodes = true;
        plan.wavelengths = nodes;
        plan.spectrum_error = error;
        return;
    }
}

// Expansion in the displacement d: the smallest order n with (2 pi f_c d)^n / (n + 1)! <= accuracy (see the top of this
// file). Rounding of the image adds kRounding / (2 pi f_c d) of the signal.
void choose_displacement_order(const Scene &scene, const Pupil &pupil, const Light &light, Plan &plan) {
    const double phase = 2 * kPi * cutoff_of(pupil, light, plan.pixels) * max_signal_px(scene.signal);
    double error = 1;
    for (size_t order = 1; order <= kMaxOrder; order++) {
        error *= phase / static_cast<double>(order + 1);
        plan.order = order;
        plan.series_error = error + (phase > 0 ? kRounding / phase : 0);
        if (order >= kMinOrder && error <= scene.accuracy)
            return;
    }
    plan.frames = Frames::propagation;
    plan.order = kMinOrder;
    plan.series_error = 0;
}

// Frames of moving stars, and those whose displacement is beyond the expansion.
void choose_frames(const Scene &scene, const Light &farthest, Plan &plan) {
    if (plan.frames == Frames::series && !scene.systematics.any() && !scene.binary.moving)
        return;
    plan.frames = Frames::propagation;
    if (plan.engine == EngineKind::padded_fft || plan.atlas.oversampling == 0 || scene.systematics.changes_optics())
        return;
    for (size_t star = 0; star < scene.stars.size(); star++) {
        for (size_t axis = 0; axis < 2; axis++)
            plan.atlas.reach[star][axis] = std::fabs(farthest.offset_px[star][axis]) + kAtlasMargin;
        const Grid grid = atlas_grid(plan, plan.atlas.reach[star]);
        if (grid.rows * grid.cols > kMostAtlasSamples)
            return;
    }
    plan.frames = Frames::atlas;
}

// Error of N x N pupil samples. Where the phase jumps between two cells, the true boundary may run anywhere between
// their centres: the field error is the jump times an area that is uniform over +- half a cell (variance 1/12 cell^2).
// In grey cells at the edge of the aperture the centroid of the light is off the cell's centre by a tenth of a cell or
// so. Both add as random errors over the pupil; their sum is compared with the field of the brightest pixel, and the
// relative error of an intensity is twice that of its field. A cell that holds the average over its area is off by its
// centroid only, times the jump.
double pupil_error(const Pupil &pupil, const Light &light, const Grid &pixels, double peak) {
    const size_t n = pupil.samples;
    const double wavenumber = 1 / light.wavelength_m[light.wavelength_m.size() / 2];
    const double off_centre = kGreyOffset * 2 * kPi / static_cast<double>(n);
    const double mixed_error = 2 * std::sin(kPi * wavenumber * pupil.step_m) * off_centre;
    std::vector<bool> mixed(n * n, false);
    double sum = 0;
    for (const MixedCell &cell : pupil.mixed) {
        mixed[cell.index] = true;
        sum += pupil.amplitude[cell.index] * mixed_error * mixed_error;
    }
    for (size_t i = 0; i + n < n * n; i++) {
        const double amplitude = pupil.amplitude[i];
        for (const size_t next : {i + 1, i + n}) {
            if (mixed[i] || mixed[next])
                continue;
            const double jump = 2 * std::sin(kPi * wavenumber * (pupil.opd_m[next] - pupil.opd_m[i]));
            sum += amplitude * pupil.amplitude[next] * jump * jump / 12;
        }
        if (amplitude > 0 && amplitude < 1)
            sum += off_centre * off_centre;
    }
    double photons = 0;
    for (const std::vector<double> &star : light.photons)
        photons = std::max(photons, std::accumulate(star.begin(), star.end(), 0.0));
    const auto step = static_cast<double>(step_of(pupil, pixels, wavenumber));
    return peak > 0 ? 2 * kWorstPixelSigmas * std::sqrt(sum * photons / (peak * pupil.area)) * step : 1;
}

// The filter for the derivative by a smear, on images with this cutoff per sample.
PixelFilter smear_filter(const std::optional<Smear> &smear, double cutoff, Blur blur, double accuracy) {
    if (!smear)
        return {};
    blur.path = path_of_rate(*smear, cutoff * blur.pixel, kPathShare * accuracy);
    return make_filter(cutoff, blur, accuracy);
}

// The fewest samples per pixel that a window interpolates well, and the fewest taps with which its aliases are within
// the accuracy, also relative to the slope of the image.
AtlasPlan atlas_plan(double cutoff, const Blur &blur, const std::optional<Smear> &smear, double accuracy) {
    AtlasPlan plan;
    if (accuracy < kRounding)
        return plan;
    plan.oversampling = static_cast<size_t>(std::max(1.0, std::ceil(cutoff / kMaxAtlasCutoff)));
    plan.blur = blur;
    plan.blur.pixel = static_cast<double>(plan.oversampling);
    const double frequency = plan.cutoff = cutoff / plan.blur.pixel;
    for (size_t taps = kFewestTaps; taps <= kernels::kMostTaps; taps += 2) {
        plan.blur.window = kernels::Window::make(taps, frequency);
        plan.error = kAliasMargin * plan.blur.window.error(frequency);
        if (plan.error <= (1 - kFilterShare) * accuracy)
            break;
    }
    plan.filter = make_filter(frequency, plan.blur, kFilterShare * accuracy);
    plan.smear_filter = smear_filter(smear, frequency, plan.blur, accuracy);
    plan.error += plan.filter.error;
    return plan;
}

} // namespace

Grid grid_of(const Detector &detector) noexcept {
    const Geometry geometry = geometry_of(detector);
    const long double u_x = 1 / static_cast<long double>(geometry.xx), v_y = 1 / static_cast<long double>(geometry.yy);
    return {detector.rows,
            detector.cols,
            detector.pixel_scale_arcsec * kLongPi / 648000,
            u_x,
            -geometry.yx * u_x * v_y,
            v_y};
}

Grid atlas_grid(const Plan &plan, const std::array<double, 2> &reach) noexcept {
    const size_t finer = plan.atlas.oversampling;
    const auto samples = [&](size_t pixels, double px) {
        const double half = std::ceil((0.5 * static_cast<double>(pixels - 1) + px) * static_cast<double>(finer));
        return 2 * (static_cast<size_t>(half) + plan.atlas.blur.window.taps / 2 + 1) + 1;
    };
    Grid grid = plan.pixels;
    grid.rows = samples(plan.pixels.rows, reach[1]);
    grid.cols = samples(plan.pixels.cols, reach[0]);
    grid.pitch_rad /= static_cast<long double>(finer);
    return grid;
}

Plan with_accurate_spectrum(Plan plan, const Scene &scene, const Pupil &pupil, const Light &light) {
    const Light farthest = farthest_with_shifts(scene, farthest_on_orbit(scene, light));
    const Pupil coarse = pupil_for_estimates(pupil, refuse_aliases(scene, pupil, farthest, plan));
    plan.nodes = false;
    choose_wavelengths(scene, coarse, farthest, rough_peak(coarse, light, plan.pixels, plan.workers), plan.workers,
                       plan);
    return plan;
}

Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers) {
    Plan plan;
    plan.engine = engine;
    plan.workers = workers;
    const Detector &detector = scene.detector;
    plan.pixels = grid_of(detector);
    const double cutoff =
        cutoff_of(pupil, light, plan.pixels) * (1 + four_sigma_of(scene.systematics.scale, scene.cadence));
    const std::optional<Smear> &smear = scene.systematics.smear;
    Blur blur = {detector.integrated, blur_of(scene), 1, {}, {}};
    if (smear)
        blur.path = path_of(*smear, cutoff, kPathShare * scene.accuracy);
    plan.filter = make_filter(cutoff, blur, scene.accuracy);
    plan.smear_filter = smear_filter(smear, cutoff, blur, scene.accuracy);
    plan.atlas = atlas_plan(cutoff, blur, smear, scene.accuracy);
    if (engine == EngineKind::padded_fft)
        check_padded_fft(scene, light, plan);
    const Light farthest = farthest_with_shifts(scene, farthest_on_orbit(scene, light));
    const Pupil coarse = pupil_for_estimates(pupil, refuse_aliases(scene, pupil, farthest, plan));
    const double peak = rough_peak(coarse, light, plan.pixels, workers);
    choose_wavelengths(scene, coarse, farthest, peak, workers, plan);
    plan.pupil_error = pupil_error(pupil, light, plan.pixels, peak);
    choose_displacement_order(scene, pupil, light, plan);
    plan.orbit_px = orbit_px_per_day(scene, light) * longest_days(scene.cadence);
    choose_frames(scene, farthest, plan);
    return plan;
}

} // namespace toliman::optics
