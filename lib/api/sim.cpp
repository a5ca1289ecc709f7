// include/toliman/sim.h
#include <toliman/sim.h>

#include "api/common.hpp"

#include <numeric>

#include "api/handles.hpp"
#include "backend/json.hpp"
#include "base/buffer.hpp"
#include "base/workers.hpp"
#include "optics/cost.hpp"
#include "optics/light.hpp"
#include "optics/stages.hpp"
#include "optics/warnings.hpp"
#include "scene/geometry.hpp"

namespace api = toliman::api;
namespace optics = toliman::optics;
using toliman::Buffer;
using toliman::fail;
using toliman::Scene;
using toliman::Status;

namespace {

constexpr api::Choice<optics::EngineKind> kEngines = {TOLIMAN_SIM_ENGINE_MATRIX_DFT, TOLIMAN_SIM_ENGINE_PADDED_FFT,
                                                      "TOLIMAN_SIM_ENGINE_..."};
constexpr api::Choice<optics::Unit> kUnits = {TOLIMAN_SIM_UNIT_PHOTON, TOLIMAN_SIM_UNIT_DN, "TOLIMAN_SIM_UNIT_..."};

optics::Settings settings_of(const toliman_sim_options &known) {
    optics::Settings settings;
    settings.workers = known.threads;
    settings.progress = {known.progress, known.progress_data};
    settings.log = {known.log, known.log_data};
    if (known.bad_pixels != nullptr)
        settings.bad_pixels = known.bad_pixels;
    settings.engine = kEngines.to_enum(known.engine);
    return settings;
}

// Calls use(settings) with the caller's options while arrays are allocated by the caller's allocator.
template <class Use> void with_options(const toliman_sim_options *options, Use use) {
    const toliman_sim_options known = api::accept(options, "options");
    const toliman::MemoryScope scope(api::memory_of(known.allocator));
    use(settings_of(known));
}

void check_displacement(double displacement_px, double limit, const std::string &name = "displacement_px") {
    if (std::isnan(displacement_px))
        fail(Status::argument, "{%s} is NaN", name.c_str());
    if (std::fabs(displacement_px) > limit)
        fail(Status::range, "{%s} = %g: must be in [%g, %g] px", name.c_str(), displacement_px, -limit, limit);
}

void check_displacements(const double *displacements_px, size_t count, double limit) {
    for (size_t i = 0; i < count; i++)
        if (!(std::fabs(displacements_px[i]) <= limit))
            check_displacement(displacements_px[i], limit, "displacements_px[" + std::to_string(i) + "]");
}

void check_frames(int64_t first, size_t count, int64_t frames) {
    if (first < 0)
        fail(Status::range, "{first} = %lld: must be at least 0", static_cast<long long>(first));
    if (first > frames || count > static_cast<uint64_t>(frames - first))
        fail(Status::range, "{first} = %lld, count = %zu: must be within the cadence of %lld frames",
             static_cast<long long>(first), count, static_cast<long long>(frames));
}

// Computes the whole image before copying it to the caller, so that a failure writes nothing.
template <class Fill> void fill_image(const toliman_sim *sim, double *image, size_t stride, Fill fill) {
    const api::Use use(sim, "sim");
    const optics::Simulator &simulator = use->simulator;
    const size_t cols = simulator.scene().detector.cols;
    api::required_image(image, stride, cols, "image");
    Buffer<double> whole(simulator.pixels());
    fill(simulator, whole.data());
    api::copy_rows(whole.data(), simulator.scene().detector.rows, cols, image, stride);
}

const Buffer<double> &image_of(const optics::Simulator &simulator, int32_t kind) {
    const optics::Images &images = simulator.images();
    switch (kind) {
    case TOLIMAN_SIM_IMAGE_BOTH:
        return images.both();
    case TOLIMAN_SIM_IMAGE_STAR_A:
        return images.star(0);
    case TOLIMAN_SIM_IMAGE_STAR_B:
        if (images.star(1).empty())
            fail(Status::argument, "{kind} = %d: the scene has star A only", kind);
        return images.star(1);
    case TOLIMAN_SIM_IMAGE_SEPARATION:
        return images.motion()[0];
    case TOLIMAN_SIM_IMAGE_CURVATURE:
        return images.motion()[1];
    case TOLIMAN_SIM_IMAGE_SHIFT_X:
        return images.disturbed().shift_x;
    case TOLIMAN_SIM_IMAGE_SHIFT_Y:
        return images.disturbed().shift_y;
    case TOLIMAN_SIM_IMAGE_VARIANCE:
        return images.variance();
    case TOLIMAN_SIM_IMAGE_ROLL:
        return images.disturbed().roll;
    case TOLIMAN_SIM_IMAGE_SCALE:
        return images.disturbed().scale;
    case TOLIMAN_SIM_IMAGE_FOCUS:
        return images.disturbed().focus;
    case TOLIMAN_SIM_IMAGE_BACKGROUND:
        return images.disturbed().background;
    default:
        fail(Status::argument, "{kind} = %d: must be one of TOLIMAN_SIM_IMAGE_..., %d to %d", kind,
             TOLIMAN_SIM_IMAGE_BOTH, TOLIMAN_SIM_IMAGE_BACKGROUND);
    }
}

optics::Quantity quantity_of(int32_t kind) noexcept {
    if (kind == TOLIMAN_SIM_IMAGE_BOTH)
        return optics::Quantity::frame;
    return kind == TOLIMAN_SIM_IMAGE_VARIANCE ? optics::Quantity::variance : optics::Quantity::derivative;
}

double total(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

void set_calibration(const std::optional<toliman::SceneCalibration> &calibration, toliman_sim_info &info) noexcept {
    const toliman::SceneCalibration verdict = calibration.value_or(toliman::SceneCalibration());
    info.calibration = !calibration || !verdict.stated ? TOLIMAN_SIM_CALIBRATION_NONE
                       : verdict.complete              ? TOLIMAN_SIM_CALIBRATION_COMPLETE
                                                       : TOLIMAN_SIM_CALIBRATION_INCOMPLETE;
    info.calibration_goodness = api::kGoodness.to_constant(verdict.goodness.verdict);
    info.calibration_chi_square = verdict.goodness.chi_square;
    info.calibration_chi_square_sigma = verdict.goodness.sigma;
}

toliman_sim_info info_of(const optics::Simulator &simulator) {
    const Scene &scene = simulator.scene();
    const optics::Light &light = simulator.light();
    const Buffer<double> &both = simulator.images().both();
    toliman_sim_info info = {};
    info.name = scene.name.c_str();
    info.wavelengths = static_cast<int32_t>(light.wavelength_m.size());
    TOLIMAN_COPY(info, scene.detector, rows, cols, pixel_scale_arcsec, bit_depth);
    TOLIMAN_COPY(info, scene.cadence, frames, exposure_s);
    TOLIMAN_COPY(info, scene.telescope, pupil_samples, aperture_m);
    info.seed = scene.noise.seed;
    TOLIMAN_COPY(info, scene.signal, amplitude_px, period_days);
    info.amplitude_uas = scene.signal.amplitude_px * scene.detector.pixel_scale_arcsec * 1e6 / pixels_along_axis(scene);
    info.separation_px = light.separation_px;
    info.flux_ratio = light.photons[1].empty() ? 0 : total(light.photons[0]) / total(light.photons[1]);
    info.peak_photons = simulator.images().peak_photons();
    info.total_photons = simulator.images().total_photons();
    info.min_displacement_px = simulator.min_displacement_px();
    info.max_displacement_px = simulator.max_displacement_px();
    info.scene_digest = scene.digest;
    info.whole_counts = simulator.detector().whole_counts() ? 1 : 0;
    info.unit = kUnits.to_constant(simulator.detector().unit());
    info.bad_pixels = static_cast<int64_t>(scene.detector.bad_pixels.size());
    info.time_zero_ns = toliman::time_zero_ns(scene.binary);
    set_calibration(scene.calibration, info);
    info.peak_counts = simulator.detector().counts_of(*std::max_element(both.begin(), both.end()));
    return info;
}

// Of a scene that gives an exposure, hence the fluxes.
void set_light(const Scene &scene, const optics::Light &light, toliman_sim_plan_info &info) {
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const toliman::Star &known = scene.stars[star];
        info.magnitude[star] = known.magnitude.value_or(info.magnitude[star]);
        info.throughput[star] = light.throughput[star];
        const double seconds = on_target_s(scene.cadence);
        if (!(seconds > 0))
            continue;
        info.electrons_per_s[star] = total(light.photons[star]) * scene.detector.qe / seconds;
        if (!known.detected)
            info.photons_per_s[star] = optics::photons_before_qe(light, star) / seconds;
    }
}

toliman_sim_plan_info plan_of(const Scene &scene, const optics::Pupil &pupil, const optics::Light &light,
                              const optics::Plan &plan) {
    toliman_sim_plan_info info = {};
    info.engine = kEngines.to_constant(plan.engine);
    TOLIMAN_COPY(info, plan, scene_wavelengths, wavelengths, order);
    info.exact_frames = plan.frames == optics::Frames::propagation ? 1 : 0;
    info.oversampling = static_cast<int32_t>(plan.filter.oversampling);
    info.filter_taps = static_cast<int32_t>(plan.filter.empty() ? 0 : 2 * plan.filter.margin() + 1);
    info.pupil_samples = static_cast<int64_t>(pupil.samples);
    for (size_t stage = 0; stage < optics::kStages; stage++)
        if (optics::has_stage(scene, stage))
            info.stages |= int64_t{1} << stage;
    info.accuracy = scene.accuracy;
    TOLIMAN_COPY(info, plan, pupil_error, spectrum_error, series_error);
    info.pixel_error = plan.filter.error;
    for (const double error : plan.plate_scale_errors)
        info.plate_scale_error = std::max(info.plate_scale_error, std::fabs(error));
    info.fft_side = static_cast<int64_t>(plan.fft_side);
    for (int i = 0; i < 2; i++)
        info.fft_cells[i] = static_cast<int64_t>(plan.fft_cells[i]);
    info.rounding_error = optics::kRounding;
    if (plan.frames == optics::Frames::atlas) {
        info.atlas_taps = static_cast<int64_t>(plan.atlas.blur.window.taps);
        info.atlas_error = plan.atlas.error;
        info.atlas_oversampling = static_cast<int64_t>(plan.atlas.oversampling);
    }
    info.open_area_m2 = optics::open_area_m2(pupil);
    info.magnitude[0] = info.magnitude[1] = std::numeric_limits<double>::quiet_NaN();
    set_light(scene, light, info);
    info.orbit_px = plan.orbit_px;
    info.bad_pixels = static_cast<int64_t>(scene.detector.bad_pixels.size());
    const optics::Cost cost = optics::cost_of(scene, pupil, plan);
    TOLIMAN_COPY(info, cost, setup_flops, frame_flops, bytes, setup_s, frame_s);
    return info;
}

// Makes frames on worker threads by make(i, scratch [pixels], image); worker w makes frames w, w + workers, ... with
// its own scratch memory. Noise is counter-based, so that the result does not depend on the partition.
template <class Make>
void make_frames(size_t pixels, size_t count, uint32_t threads, double *images, const Make &make) {
    const size_t workers = std::max<size_t>(1, std::min<size_t>(toliman::worker_count(threads), count));
    std::vector<Buffer<double>> scratch(workers, Buffer<double>(pixels));
    toliman::run_jobs(static_cast<unsigned>(workers), workers, [&](size_t worker) {
        for (size_t i = worker; i < count; i += workers)
            make(i, scratch[worker].data(), images + i * pixels);
    });
}

// The electrons of an expected image; rounding alone takes no pixel farther below 0 than kRoundingE.
void electrons_of(const optics::Simulator &simulator, const double *expected, size_t frame, double *electrons) {
    constexpr double kRoundingE = 1e-6;
    const size_t pixels = simulator.pixels(), cols = simulator.scene().detector.cols;
    const optics::DetectorStages &detector = simulator.detector();
    std::copy_n(expected + frame * pixels, pixels, electrons);
    detector.undo_expected(electrons);
    for (size_t i = 0; i < pixels; i++) {
        const double counts = expected[frame * pixels + i];
        electrons[i] = (electrons[i] - detector.bias()) * detector.e_per_count();
        if (!std::isfinite(counts) || electrons[i] < -kRoundingE)
            fail(Status::argument, "{expected}[%zu][%zu][%zu] = %g: must be finite, and at least the bias, %g", frame,
                 i / cols, i % cols, counts, simulator.detector().bias());
        electrons[i] = std::max(0.0, electrons[i]);
    }
}

optics::Outline outline_of_text(const char *json, size_t size, const char *folder, const optics::Settings &settings) {
    if (size > toliman::json::kLargestText) // checked before the text is copied: a wrong size may be huge
        fail(Status::format, "scene: %zu bytes: must be at most %zu", size, toliman::json::kLargestText);
    const bool current = folder == nullptr || *folder == '\0';
    return optics::outline_of(std::string(json, size), "scene", current ? "." : folder, settings);
}

// Outline: settings -> the outline of a scene.
template <class Outline> void create(const toliman_sim_options *options, toliman_sim **out, Outline outline_of) {
    api::required(out, "out");
    with_options(options, [&](const optics::Settings &settings) {
        *out = new toliman_sim{{}, optics::Simulator(outline_of(settings), settings), settings.workers};
    });
}

template <class Outline>
void make_plan(const toliman_sim_options *options, toliman_sim_plan_info *out, Outline outline_of) {
    api::required(out, "out");
    with_options(options, [&](const optics::Settings &settings) {
        const optics::Outline outline = outline_of(settings);
        optics::warn_before_images(outline, settings);
        api::deliver(plan_of(outline.scene, outline.pupil, outline.light, outline.plan), out, "out");
    });
}

} // namespace

toliman_status toliman_sim_create_file(const char *path, const toliman_sim_options *options,
                                       toliman_sim **out) noexcept {
    return api::guard([&] {
        api::required(path, "path");
        create(options, out, [&](const optics::Settings &settings) { return optics::outline_of(path, settings); });
    });
}

toliman_status toliman_sim_create_json(const char *json, size_t size, const char *folder,
                                       const toliman_sim_options *options, toliman_sim **out) noexcept {
    return api::guard([&] {
        api::required(json, "json");
        create(options, out,
               [&](const optics::Settings &settings) { return outline_of_text(json, size, folder, settings); });
    });
}

void toliman_sim_destroy(toliman_sim *sim) noexcept {
    api::destroy(sim);
}

toliman_status toliman_sim_get_info(const toliman_sim *sim, toliman_sim_info *out) noexcept {
    return api::guard([&] { api::deliver(info_of(api::Use(sim, "sim")->simulator), out, "out"); });
}

toliman_status toliman_sim_get_bounds(const toliman_sim *sim, toliman_sim_bounds *out) noexcept {
    return api::query(sim, "sim", out, [&](auto &self, auto &bounds) {
        const toliman::information::Bounds &known = self.bounds.of(self.simulator);
        bounds.crb_px = known.alone;
        bounds.crb_flux_shift_px = known.flux_shift;
        bounds.crb_marginal_px = known.marginal;
        bounds.crb_projected_px = known.projected;
        bounds.truncation = self.simulator.truncation();
        const optics::Images &images = self.simulator.bound_images();
        bounds.peak_to_mean =
            images.peak_photons() / images.total_photons() * static_cast<double>(images.both().size());
        bounds.gradient_energy = toliman::information::gradient_energy(images);
    });
}

toliman_status toliman_sim_plan_file(const char *path, const toliman_sim_options *options,
                                     toliman_sim_plan_info *out) noexcept {
    return api::guard([&] {
        api::required(path, "path");
        make_plan(options, out, [&](const optics::Settings &settings) { return optics::outline_of(path, settings); });
    });
}

toliman_status toliman_sim_plan_json(const char *json, size_t size, const char *folder,
                                     const toliman_sim_options *options, toliman_sim_plan_info *out) noexcept {
    return api::guard([&] {
        api::required(json, "json");
        make_plan(options, out,
                  [&](const optics::Settings &settings) { return outline_of_text(json, size, folder, settings); });
    });
}

toliman_status toliman_sim_get_plan(const toliman_sim *sim, toliman_sim_plan_info *out) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        api::deliver(plan_of(simulator.scene(), simulator.pupil(), simulator.light(), simulator.plan()), out, "out");
    });
}

toliman_status toliman_sim_get_stages(const toliman_sim_plan_info *plan, toliman_sim_stage *stages, size_t capacity,
                                      size_t *count) noexcept {
    return api::guard([&] {
        api::required(plan, "plan");
        const toliman_sim_plan_info known = api::copied(plan, "plan");
        const api::StructOutput<toliman_sim_stage> result(stages, "stages", capacity, count);
        result.write(optics::kStages, "stages", [&](size_t i) {
            toliman_sim_stage stage = {};
            stage.name = optics::stage_name(i);
            stage.modelled = static_cast<int32_t>(known.stages >> i & 1);
            return stage;
        });
    });
}

toliman_status toliman_sim_get_series(const toliman_sim *sim, int64_t first, size_t count, double *times_days,
                                      double *displacements_px) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        check_frames(first, count, simulator.scene().cadence.frames);
        for (size_t i = 0; i < count; i++) {
            const int64_t k = first + static_cast<int64_t>(i);
            if (times_days != nullptr)
                times_days[i] = simulator.time_days(k);
            if (displacements_px != nullptr)
                displacements_px[i] = simulator.displacement_px(k);
        }
    });
}

toliman_status toliman_sim_get_image(const toliman_sim *sim, int32_t kind, double *image, size_t stride) noexcept {
    return api::guard([&] {
        fill_image(sim, image, stride, [&](const optics::Simulator &simulator, double *whole) {
            const Buffer<double> &source = image_of(simulator, kind);
            std::copy(source.begin(), source.end(), whole);
            simulator.detector().to_counts(quantity_of(kind), simulator.images().both(), whole);
        });
    });
}

toliman_status toliman_sim_get_pupil(const toliman_sim *sim, double *amplitude, double *opd_m) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Pupil &pupil = self.simulator.pupil();
        api::copy_to(amplitude, pupil.amplitude);
        api::copy_to(opd_m, pupil.opd_m);
    });
}

toliman_status toliman_sim_get_spectrum(const toliman_sim *sim, size_t count, double *wavelength_m, double *weight_a,
                                        double *weight_b, double *plate_scale_error) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Light &light = self.simulator.light();
        api::check_count("count", count, light.wavelength_m.size(), "the number of wavelengths");
        std::vector<double> weights = light.photons[1], errors = self.simulator.plan().plate_scale_errors;
        weights.resize(count); // zeros without star B
        errors.resize(count);
        api::copy_to(wavelength_m, light.wavelength_m);
        api::copy_to(weight_a, light.photons[0]);
        api::copy_to(weight_b, weights);
        api::copy_to(plate_scale_error, errors);
    });
}

toliman_status toliman_sim_get_offsets(const toliman_sim *sim, toliman_sim_offsets *out) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Light &light = self.simulator.light();
        const double absent = std::numeric_limits<double>::quiet_NaN();
        toliman_sim_offsets offsets = {0, 0, light.offset_px[0][0], light.offset_px[0][1], absent, absent};
        if (!light.photons[1].empty()) {
            offsets.b_x_px = light.offset_px[1][0];
            offsets.b_y_px = light.offset_px[1][1];
        }
        api::deliver(offsets, out, "out");
    });
}

toliman_status toliman_sim_propagate(const toliman_sim *sim, double displacement_px, double *image,
                                     size_t stride) noexcept {
    return api::guard([&] {
        check_displacement(displacement_px, toliman::kFarthestDisplacement);
        fill_image(sim, image, stride, [&](const optics::Simulator &simulator, double *whole) {
            simulator.propagate(displacement_px, whole);
            simulator.detector().to_counts(whole);
        });
    });
}

toliman_status toliman_sim_expect(const toliman_sim *sim, double displacement_px, double *image,
                                  size_t stride) noexcept {
    return api::guard([&] {
        check_displacement(displacement_px, toliman::kLargestDisplacement);
        fill_image(sim, image, stride, [&](const optics::Simulator &simulator, double *whole) {
            simulator.expect(displacement_px, whole);
            simulator.detector().to_counts(whole);
        });
    });
}

toliman_status toliman_sim_frame(const toliman_sim *sim, const double *displacements_px, uint64_t seed, int64_t first,
                                 size_t count, double *images) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        const bool own = displacements_px != nullptr; // any frame number is then allowed
        check_frames(first, count, own ? std::numeric_limits<int64_t>::max() : simulator.scene().cadence.frames);
        if (count == 0)
            return;
        api::required_array(images, count, simulator.pixels() * sizeof *images, "images");
        check_displacements(displacements_px, own ? count : 0, simulator.largest_displacement_px());
        make_frames(simulator.pixels(), count, self.threads, images, [&](size_t i, double *scratch, double *image) {
            const int64_t k = first + static_cast<int64_t>(i);
            simulator.frame(own ? displacements_px[i] : simulator.displacement_px(k), seed, k, scratch, image);
        });
    });
}

toliman_status toliman_sim_expose(const toliman_sim *sim, const double *expected, uint64_t seed, int64_t first,
                                  size_t count, double *images) noexcept {
    return api::call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        check_frames(first, count, std::numeric_limits<int64_t>::max());
        if (count == 0)
            return;
        const size_t size = simulator.pixels() * sizeof *images;
        api::required_array(expected, count, size, "expected");
        api::required_array(images, count, size, "images");
        make_frames(simulator.pixels(), count, self.threads, images, [&](size_t i, double *scratch, double *image) {
            electrons_of(simulator, expected, i, scratch);
            simulator.expose(seed, first + static_cast<int64_t>(i), scratch, image);
        });
    });
}
