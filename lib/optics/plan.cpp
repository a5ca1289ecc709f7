#include "optics/plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "backend/blas.hpp"
#include "optics/nodes.hpp"
#include "optics/padded_fft.hpp"
#include "optics/reach.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNodeMargin = 4;     // node errors are found on a few pixels: measured 0.3 to 3 of those of all pixels
constexpr size_t kFewWavelengths = 8; // not worth fewer
constexpr double kGreyOffset = 0.2;   // cells
constexpr double kWorstOfMany = 4;    // standard deviations of the worst pixel
constexpr size_t kLeastOrder = 2, kMostOrder = 8;
constexpr double kShortestAnchor = 1e-3; // days

// For what a plan takes: operations a pupil cell and a pixel besides the products, and speeds of one core. They are
// those of a 2020s server core and only steer expectations.
constexpr double kFieldFlops = 60, kImageFlops = 12, kElementRate = 4e10, kPaddedRate = 3;
constexpr double kPlaceSeconds = 0.9e-9; // more images than a cache holds
constexpr double kTermSeconds = 0.3e-9, kPoissonSeconds = 7e-9, kReadSeconds = 7e-9;
constexpr double kStarFields = 4;   // the image, its slopes and focus
constexpr double kFrameImages = 10; // kept besides the derivatives along the displacement and by places

// Highest frequency of an image, in cycles per pixel.
double cutoff_of(const Pupil &pupil, const Light &light, const Grid &pixels) noexcept {
    return pupil.aperture_m * static_cast<double>(pixels.pitch_rad) / light.wavelength_m.front();
}

// Images repeat themselves, every N lambda/D or every side of the FFT: each pixel must be nearer to a star than to its
// repetitions, wherever the star gets.
void refuse_aliases(const Scene &scene, const Pupil &pupil, const Light &farthest, const Plan &plan) {
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const auto finer = static_cast<double>(plan.filter.oversampling);
    const double half[2] = {static_cast<double>(grid.cols) / finer / 2, static_cast<double>(grid.rows) / finer / 2};
    const bool padded = plan.engine == EngineKind::padded_fft;
    const double a_sample = 0.5 / cutoff_of(pupil, farthest, plan.pixels); // px that a sample more of the pupil adds
    const double most_px = padded ? 0.5 * static_cast<double>(padded_side(grid)) / finer
                                  : a_sample * static_cast<double>(kMostPupilSamples);
    const char *const source = scene.source.c_str();
    double reach_px = 0;
    for (size_t star = 0; star < scene.stars.size(); star++)
        for (size_t axis = 0; axis < 2; axis++) {
            const double place = std::fabs(farthest.offset_px[star][axis]), reach = half[axis] + place;
            reach_px = std::max(reach_px, reach);
            if (reach > most_px && place > half[axis] && most_px > 2 * half[axis])
                fail(Status::scene,
                     "%s: {binary}: star %c is outside the frame of %zu x %zu by %.0f px: at most %.0f px "
                     "are allowed there, or its image repeats itself in the frame",
                     source, star == 0 ? 'A' : 'B', plan.pixels.rows, plan.pixels.cols, place - half[axis],
                     most_px - 2 * half[axis]);
        }
    const double needed = std::ceil(reach_px / a_sample);
    if (!padded && static_cast<double>(pupil.samples) < needed)
        fail(Status::scene, "%s: {telescope.pupil_samples} = %zu: must be at least %.0f, or the frame shows aliases%s",
             source, pupil.samples, needed,
             needed > static_cast<double>(kMostPupilSamples)
                 ? "; 2048 at most are: make detector.shape or detector.pixel_scale_arcsec smaller"
                 : "");
}

// This engine samples the pupil anew at each wavelength, and takes each of the scene's.
void check_padded_fft(const Scene &scene, const Light &light, Plan &plan) {
    const Telescope &telescope = scene.telescope;
    if (telescope.mask.kind == Mask::Kind::file || !telescope.amplitude_file.empty() || !telescope.opd_file.empty())
        fail(Status::unsupported,
             "%s: {telescope}: the fft engine samples the pupil anew at each wavelength: it takes "
             "no mask, amplitude or OPD file",
             scene.source.c_str());
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const size_t most = embedded_samples(scene, grid, 1 / light.wavelength_m.front());
    if (most > padded_side(grid))
        fail(Status::scene,
             "%s: {detector.pixel_scale_arcsec} = %g: the fft engine would need %zu cells in %zu: make it smaller",
             scene.source.c_str(), scene.detector.pixel_scale_arcsec, most, padded_side(grid));
    plan.plate_scale_errors = plate_scale_errors(scene, sampling_grid(plan.pixels, plan.filter), light.wavelength_m);
}

void choose_wavelengths(const Scene &scene, const Pupil &pupil, const Light &light, double peak, unsigned workers,
                        Plan &plan) {
    plan.wavelengths = plan.scene_wavelengths = light.wavelength_m.size();
    // An accuracy below rounding asks for no approximation at all.
    if (plan.wavelengths <= kFewWavelengths || plan.engine == EngineKind::padded_fft || scene.accuracy < kRounding)
        return;
    if (!(peak > 0)) // lines may cancel in the rough look
        return;
    const std::vector<double> errors = node_errors(pupil, light, plan.pixels, workers);
    for (size_t nodes = 1; nodes < std::min(errors.size(), plan.scene_wavelengths); nodes++) {
        const double error = kNodeMargin * errors[nodes] / peak;
        if (!(error <= scene.accuracy))
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
    const double turn = 2 * kPi * cutoff_of(pupil, light, plan.pixels) * farthest_of(scene.signal);
    double error = 1;
    for (size_t order = 1; order <= kMostOrder; order++) {
        error *= turn / static_cast<double>(order + 1);
        plan.order = order;
        plan.series_error = error + (turn > 0 ? kRounding / turn : 0);
        if (order >= kLeastOrder && error <= scene.accuracy)
            return;
    }
    plan.exact_frames = true;
    plan.order = kLeastOrder;
    plan.series_error = 0;
}

// Phases at 4 sigma: a stretch moves a pixel's light by its distance from the axis; defocus turns them by up to sqrt(3)
// of its rms to either side.
struct Shapes {
    double stretched, turned;
};

Shapes shapes_of(const Scene &scene, const Light &light, double frequency, const Grid &pixels) {
    const Systematics &systematics = scene.systematics;
    const double corner = 0.5 * std::hypot(static_cast<double>(pixels.rows), static_cast<double>(pixels.cols));
    return {frequency * corner * reach_of(systematics.scale, scene.cadence),
            2 * std::sqrt(3) * 2e-9 * kPi / light.wavelength_m.front() * reach_of(systematics.focus_nm, scene.cadence)};
}

// The series in the place is also that of the signal's slope, of which it leaves out d^n/n! times the n-th derivative.
// Left out are the square of the stretch, the cube of the phase, and their products with all else.
void choose_places(const Scene &scene, const Pupil &pupil, const Light &light, Plan &plan) {
    const double frequency = 2 * kPi * cutoff_of(pupil, light, plan.pixels);
    const double moved = wandering_px(scene, light) + farthest_of(scene.signal);
    const auto [stretched, turned] = shapes_of(scene, light, frequency, plan.pixels);
    const double rest = frequency * moved + reach_of(scene.systematics.flux, scene.cadence);
    plan.scale_focus_error =
        stretched * stretched / 2 + turned * turned * turned / 6 + stretched * turned + (stretched + turned) * rest;

    double error = frequency * moved;
    for (size_t order = kLeastOrder; !plan.exact_frames && order <= kMostOrder; order++) {
        error *= frequency * moved / static_cast<double>(order);
        plan.place_order = order;
        plan.place_error = error;
        if (error <= scene.accuracy)
            return;
    }
    plan.exact_frames = true;
    plan.place_order = 0;
    plan.series_error = plan.place_error = 0;
}

// Stars that follow an orbit: a higher order reaches farther from an anchor but takes more fields. The plan is the
// cheapest, and exact frames where there are fewer of them than fields.
void choose_anchors(const Scene &scene, const Pupil &pupil, const Light &light, Plan &plan) {
    const double frequency = 2 * kPi * cutoff_of(pupil, light, plan.pixels);
    const double speed = orbit_px_a_day(scene, light), span = span_days(scene.cadence);
    const double moved = wandering_px(scene, light) + farthest_of(scene.signal);
    auto least = static_cast<double>(scene.cadence.frames);
    plan.orbit_px = speed * longest_days(scene.cadence);
    plan.exact_frames = true;
    plan.place_order = 0;
    double factorial = 1;
    for (size_t order = 1; order <= kMostOrder; order++) {
        factorial *= static_cast<double>(order);
        const auto n = static_cast<double>(order);
        const double reach = std::pow(scene.accuracy * factorial, 1 / n) / frequency - moved;
        if (order < kLeastOrder || reach <= 0)
            continue;
        const double anchors = std::max(1.0, std::ceil(span * speed / (2 * reach)));
        const double fields = anchors * (n + 1) * (n + 2) / 2;
        if (fields >= least)
            continue;
        least = fields;
        plan.exact_frames = false;
        plan.place_order = order;
        plan.anchors = static_cast<size_t>(anchors);
        plan.anchor_days = std::max(span / anchors, kShortestAnchor);
        plan.place_error = std::pow(frequency * (moved + speed * plan.anchor_days / 2), n) / factorial;
    }
    if (!plan.exact_frames) { // the shapes are those at the anchor
        const auto [stretched, turned] = shapes_of(scene, light, frequency, plan.pixels);
        plan.scale_focus_error += (stretched + turned) * frequency * speed * plan.anchor_days / 2;
    }
    plan.order = kLeastOrder;
    plan.series_error = plan.place_error;
}

// Where the phase jumps between two cells the boundary may run anywhere between their centres: the field there is off
// by the jump times an area spread evenly over half a cell to either side. Grey cells at the edge of the aperture hold
// their light off their own centre by a tenth of a cell or so. Both add at random over the pupil, and the sum stands
// against the field of the brightest pixel.
double pupil_error(const Pupil &pupil, const Light &light, const Grid &pixels, double peak) {
    const size_t n = pupil.samples;
    const double wavenumber = 1 / light.wavelength_m[light.wavelength_m.size() / 2];
    const double off_centre = kGreyOffset * 2 * kPi / static_cast<double>(n);
    double sum = 0;
    for (size_t i = 0; i + n < n * n; i++) {
        const double here = pupil.amplitude[i];
        for (const size_t next : {i + 1, i + n}) {
            const double jump = 2 * std::sin(kPi * wavenumber * (pupil.opd_m[next] - pupil.opd_m[i]));
            sum += here * pupil.amplitude[next] * jump * jump / 12;
        }
        if (here > 0 && here < 1)
            sum += off_centre * off_centre;
    }
    double photons = 0;
    for (const std::vector<double> &star : light.photons)
        photons = std::max(photons, std::accumulate(star.begin(), star.end(), 0.0));
    const auto step = static_cast<double>(step_of(pupil, pixels, wavenumber));
    return peak > 0 ? 2 * kWorstOfMany * std::sqrt(sum * photons / (peak * pupil.area)) * step : 1;
}

// Images that are propagated, by what they are for.
struct Fields {
    double stars;
    double orders;  // of the moving star, beyond those of any star
    double of_star; // of any star
    double places;  // of the series in places, both stars together
};

Fields fields_of(const Scene &scene, const Plan &plan) noexcept {
    const auto stars = static_cast<double>(scene.stars.size());
    const size_t terms = plan.place_order > 0 ? (plan.place_order + 1) * (plan.place_order + 2) / 2 : 0;
    const double focus = scene.systematics.focus_nm.any() ? 1 : 0;
    return {stars, static_cast<double>(plan.order + 1), kStarFields + focus + static_cast<double>(terms),
            stars * static_cast<double>(terms)};
}

// What is kept, and besides the more of what makes the images of a star and what makes frames on all workers.
double bytes_of(const Pupil &pupil, const Plan &plan, const Fields &fields) noexcept {
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const auto pixels = static_cast<double>(plan.pixels.rows * plan.pixels.cols);
    const auto samples = static_cast<double>(grid.rows * grid.cols), n = static_cast<double>(pupil.samples);
    const auto cols = static_cast<double>(grid.cols), side = static_cast<double>(padded_side(grid));
    const bool padded = plan.engine == EngineKind::padded_fft;
    const auto chunks = static_cast<double>(std::min(plan.wavelengths, kWavelengthChunks));
    const double workers = plan.workers, busy = std::min(workers, chunks);
    const double field = 2 * n * n + 2 * samples + (padded ? 0 : 2 * n * cols);
    // Each chunk of the wavelengths has its own images; who works on one has fields of the pupil.
    const auto making = [&](double images) {
        return images * (chunks * samples + busy * field) + (padded ? 2 * busy * side * side : 0);
    };
    const double series = plan.anchors > 0 ? static_cast<double>(kKeptAnchors) * fields.places : fields.places;
    const double kept = 3 * n * n + pixels * (kFrameImages + fields.orders + series);
    const double frames = workers * (pixels + (plan.exact_frames ? making(1) : 0));
    return sizeof(double) * (kept + std::max(making(fields.orders + fields.of_star), frames));
}

} // namespace

Cost cost_of(const Scene &scene, const Pupil &pupil, const Plan &plan) {
    const Grid grid = sampling_grid(plan.pixels, plan.filter);
    const auto pixels = static_cast<double>(plan.pixels.rows * plan.pixels.cols);
    const auto samples = static_cast<double>(grid.rows * grid.cols);
    const auto wavelengths = static_cast<double>(plan.wavelengths);
    const bool padded = plan.engine == EngineKind::padded_fft;
    const auto n = static_cast<double>(pupil.samples), rows = static_cast<double>(grid.rows);
    const auto cols = static_cast<double>(grid.cols), side = static_cast<double>(padded_side(grid));
    // A fifth of the first product is outside the round pupil and skipped.
    const double transform = padded ? 10 * side * side * std::log2(side) : n * cols * (1.6 * n + 2 * rows);
    const double elements = kFieldFlops * n * n + kImageFlops * samples;
    const double filter = plan.filter.empty() ? 0 : 3 * static_cast<double>(plan.filter.taps.size()) * 2 * samples;
    const double one_image = wavelengths * (transform + elements) + filter;

    const Fields in = fields_of(scene, plan);
    const double fields = in.orders + in.stars * in.of_star;
    const double rate = 1e9 * (padded ? kPaddedRate : blas::measure_tile_gflops());
    Cost cost;
    cost.setup_flops = fields * (wavelengths * (transform + elements) + filter);
    cost.setup_s = fields * ((wavelengths * transform + filter) / rate + wavelengths * elements / kElementRate);
    cost.frame_flops = 2 * static_cast<double>(plan.order) * pixels;
    cost.frame_s = pixels * (kTermSeconds * static_cast<double>(plan.order) +
                             (scene.noise.photon ? kPoissonSeconds : 0) + (scene.noise.read_e > 0 ? kReadSeconds : 0));
    if (plan.place_order > 0) {
        cost.frame_flops += 2 * in.places * pixels;
        cost.frame_s += in.places * pixels * kPlaceSeconds;
    }
    if (plan.exact_frames) {
        const double moving = scene.systematics.any() ? in.stars : 1;
        cost.frame_flops += moving * one_image;
        cost.frame_s += moving * (wavelengths * (transform / rate + elements / kElementRate) + filter / rate);
    }
    cost.bytes = bytes_of(pupil, plan, in);
    return cost;
}

Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers) {
    Plan plan;
    plan.engine = engine;
    plan.workers = workers;
    const Detector &detector = scene.detector;
    plan.pixels = {detector.rows, detector.cols, detector.pixel_scale_arcsec * 3.14159265358979323846264L / 648000};
    plan.filter = make_filter(cutoff_of(pupil, light, plan.pixels), detector.integrated, scene.systematics.jitter_px,
                              scene.accuracy);
    if (engine == EngineKind::padded_fft)
        check_padded_fft(scene, light, plan);
    const Light on_orbit = farthest_on_orbit(scene, light), farthest = farthest_out(scene, on_orbit);
    refuse_aliases(scene, pupil, farthest, plan);
    const double peak = rough_peak(pupil, light, plan.pixels, workers);
    choose_wavelengths(scene, pupil, farthest, peak, workers, plan);
    plan.pupil_error = pupil_error(pupil, light, plan.pixels, peak);
    choose_order(scene, pupil, light, plan);
    if (scene.systematics.any())
        choose_places(scene, pupil, on_orbit, plan);
    if (scene.binary.moving)
        choose_anchors(scene, pupil, on_orbit, plan);
    return plan;
}

} // namespace toliman::optics
