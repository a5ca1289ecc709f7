// include/toliman/calibrate.h
#include <toliman/calibrate.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>

#include "api/fit_values.hpp"
#include "api/goodness.hpp"
#include "api/guard.hpp"
#include "api/handles.hpp"
#include "api/journal.hpp"
#include "api/memory.hpp"
#include "api/option.hpp"
#include "api/parameters.hpp"
#include "api/pixel_frames.hpp"
#include "api/struct_array.hpp"
#include "backend/file.hpp"
#include "base/workers.hpp"
#include "calibrate/calibrate.hpp"
#include "calibrate/fitted.hpp"
#include "calibrate/improve.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/prior.hpp"
#include "scene/instrument.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_calibration : Handle<toliman_calibration> {
    static constexpr char kType[] = "toliman_calibration";
    calibrate::Calibration calibration;
};

namespace {

constexpr int32_t kMostIterations = 1000;
constexpr double kMostDays = 1e6;
constexpr double kNoMap = 1e-15;       // m
constexpr size_t kMostUnknowns = 4096; // parameters times windows
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void check_scene(const optics::Simulator &simulator) {
    const Scene &scene = simulator.scene();
    const char *const source = scene.source.c_str();
    if (scene.stars.size() < 2)
        fail(Status::unsupported, "%s: {stars}: a calibration needs two stars", source);
    if (simulator.plan().engine == optics::EngineKind::padded_fft)
        fail(Status::unsupported, "%s: a calibration needs the matrix DFT: the padded FFT has no derivatives", source);
}

// The scene with absolute photons. Photons relative to the peak of the image would change with the optics.
Scene with_photons(const optics::Simulator &simulator) {
    Scene scene = simulator.scene();
    if (scene.cadence.peak_photons == 0)
        return scene;
    scene.cadence.peak_photons = 0;
    scene.cadence.exposure_s = 1;
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const std::vector<double> &photons = simulator.light().photons[star];
        scene.stars[star].photons_per_s = std::accumulate(photons.begin(), photons.end(), 0.0);
    }
    return scene;
}

// Windows of `days` from the first time on: those with frames, and those whose start is the end of one with frames.
std::vector<calibrate::Window> windows_of(const std::vector<fit::Prediction> &predictions, double days) {
    const double first = std::min_element(predictions.begin(), predictions.end(), [](const auto &a, const auto &b) {
                             return a.days < b.days;
                         })->days;
    std::map<double, calibrate::Window> windows; // by their number
    for (size_t k = 0; k < predictions.size(); k++) {
        const double elapsed = predictions[k].days - first, number = days > 0 ? std::floor(elapsed / days) : 0,
                     share = days > 0 ? std::clamp(elapsed / days - number, 0.0, 1.0) : 0;
        windows[number].frames.push_back(k);
        windows[number].shares.push_back(share);
        if (share > 0)
            windows[number + 1];
    }
    std::vector<calibrate::Window> all;
    double before = -1;
    for (auto &[number, window] : windows) {
        window.first_days = days > 0 ? first + number * days : first;
        window.elapsed = number - before;
        before = number;
        all.push_back(std::move(window));
    }
    return all;
}

std::vector<fit::Prediction> predictions_of(const toliman_fit_prediction *given, size_t count,
                                            const optics::Simulator &simulator) {
    std::vector<fit::Prediction> predictions(count);
    for (size_t k = 0; k < count; k++)
        predictions[k].days = simulator.time_days(static_cast<int64_t>(k));
    if (given == nullptr)
        return predictions;
    const StructArray<const toliman_fit_prediction> all(given, "predictions");
    for (size_t k = 0; k < count; k++)
        in_frame(k, [&] { predictions[k] = prediction_of(all.get(k), "prediction"); });
    return predictions;
}

// Edges and number of the pupil cells of `start` become those of the nominal scene. Returns what changed.
uint32_t adopt_cells(const toliman_sim *start, Scene &nominal) {
    if (start == nullptr)
        return 0;
    const Use use(start, "options->start");
    const Telescope &from = use->simulator.scene().telescope;
    Telescope &to = nominal.telescope;
    const uint32_t changes = (from.mask.edges != to.mask.edges ? calibrate::lacks_edges : 0u) |
                             (from.pupil_samples != to.pupil_samples ? calibrate::lacks_samples : 0u);
    to.mask.edges = from.mask.edges;
    to.pupil_samples = from.pupil_samples;
    return changes;
}

// Where the calibration starts: changes of the parameters, the same in all windows, and the map that they do not
// explain.
calibrate::Point start_of(const calibrate::Problem &problem, const optics::Outline &nominal, const toliman_sim *start) {
    calibrate::Point from;
    std::vector<double> changes(problem.free.size());
    from.instrument.assign(problem.windows.size(), changes);
    if (start == nullptr)
        return from;
    const Use use(start, "options->start");
    const Scene &scene = use->simulator.scene();
    const optics::Pupil &pupil = use->simulator.pupil(), &same = nominal.pupil;
    const bool agree = scene.detector.rows == problem.nominal.detector.rows &&
                       scene.detector.cols == problem.nominal.detector.cols &&
                       scene.stars.size() == problem.nominal.stars.size() && pupil.samples == same.samples &&
                       pupil.step_m == same.step_m && pupil.amplitude == same.amplitude &&
                       use->simulator.light().wavelength_m == nominal.light.wavelength_m;
    if (!agree)
        fail(Status::mismatch,
             "{options->start}: %s: must be %s with other values of the parameters: detector, pupil and band differ",
             scene.source.c_str(), problem.nominal.source.c_str());
    for (size_t i = 0; i < problem.free.size(); i++)
        changes[i] = change_of(scene, problem.nominal, problem.free[i].parameter);
    from.instrument.assign(problem.windows.size(), changes);
    const optics::Outline outline = calibrate::outline_at(problem, changes, {});
    from.map_m.resize(outline.pupil.opd_m.size());
    for (size_t i = 0; i < from.map_m.size(); i++)
        from.map_m[i] = pupil.opd_m[i] - outline.pupil.opd_m[i];
    if (std::all_of(from.map_m.begin(), from.map_m.end(), [](double m) { return std::fabs(m) < kNoMap; }))
        from.map_m = {}; // rounding alone
    return from;
}

const calibrate::Calibration &known(const toliman_calibration &handle, int64_t window) {
    required_index(window, handle.calibration.windows.size(), "window");
    return handle.calibration;
}

bool has_values(const calibrate::Calibration &calibration) {
    return (calibration.flags & calibrate::not_converged) == 0 && !calibration.underway;
}

// Sets an image [rows][stride] to values [rows][cols], or to NaN without values.
void deliver_image(const Buffer<double> &values, const calibrate::Calibration &calibration, double *image,
                   size_t stride) {
    const size_t rows = calibration.nominal.detector.rows, cols = calibration.nominal.detector.cols;
    required_image(image, stride, cols, "image");
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < cols; x++)
            image[y * stride + x] = values.empty() ? kNan : values[y * cols + x];
}

toliman_calibration_step public_step(const calibrate::Report &report) {
    toliman_calibration_step step = {};
    step.struct_size = sizeof step;
    step.is_map = report.of_map ? 1 : 0;
    step.iteration = report.iteration;
    step.accepted = report.accepted ? 1 : 0;
    step.chi_square = report.chi_square;
    step.largest_step = report.largest_step;
    step.change = report.lack;
    step.recalled = report.recalled ? 1 : 0;
    return step;
}

calibrate::Options options_of(const toliman_calibration_options &given) {
    calibrate::Options options;
    if ((given.flags & ~(TOLIMAN_CALIBRATION_MAP | TOLIMAN_CALIBRATION_IMPROVE)) != 0)
        fail(Status::argument, "{options->flags} = %u: must be a combination of TOLIMAN_CALIBRATION_MAP and _IMPROVE",
             given.flags);
    options.map = (given.flags & TOLIMAN_CALIBRATION_MAP) != 0;
    options.most_iterations = in_range("most_iterations", given.most_iterations, 1, kMostIterations, 30);
    options.map_rms_m = 1e-9 * in_range("map_rms_nm", given.map_rms_nm, 1e-3, 1e4, 10.0);
    options.on_step = [given](const calibrate::Calibration &so_far, const calibrate::Report &report) {
        if (given.step == nullptr)
            return;
        const toliman_calibration handle = {{}, so_far};
        const toliman_calibration_step step = public_step(report);
        if (in_callback("step", [&] { return given.step(&handle, &step, given.step_data); }) != 0)
            fail(Status::cancelled, "calibrate: cancelled by the step callback");
    };
    return options;
}

} // namespace

toliman_status toliman_calibration_create(const toliman_sim *sim, const toliman_image *image, size_t count,
                                          const toliman_fit_prediction *predictions,
                                          const toliman_calibration_options *options,
                                          toliman_calibration **out) noexcept {
    return guard([&] {
        const toliman_calibration_options given = accept(options, "options");
        const MemoryScope scope(memory_of(given.allocator));
        const Use use(sim, "sim");
        const optics::Simulator &simulator = use->simulator;
        toliman_calibration *&made = required(out, "out");
        check_scene(simulator);
        if (count < 2)
            fail(Status::argument, "{count} = %zu: must be at least 2 frames", count);
        const bool improve = (given.flags & TOLIMAN_CALIBRATION_IMPROVE) != 0;
        calibrate::Options how = options_of(given);
        calibrate::Problem problem;
        problem.nominal = with_photons(simulator);
        problem.settings.workers = worker_count(given.threads);
        if (improve)
            how.improved = adopt_cells(given.start, problem.nominal);
        const optics::Outline outline = optics::outline_of(problem.nominal, problem.settings);
        problem.peak_photons = simulator.images().peak_photons();
        const std::string free = given.free != nullptr ? given.free : "";
        problem.free = calibrate::free_of(free, problem.nominal, outline.plan, &problem.left_out);
        problem.capture_px = in_range("capture_px", given.capture_px, 0.1, fit::kMostCapturePx, 6.0);
        problem.smoothness = in_range("smoothness", given.smoothness, 1e-9, 1e3, 0.01);
        const double window_days = in_range("window_days", given.window_days, 1e-6, kMostDays, 0.0);
        const PixelFrames frames =
            frames_of(image, count, simulator.scene().detector.rows, simulator.scene().detector.cols);
        problem.frames.count = count;
        problem.frames.read = [&frames](size_t k, double *counts) {
            Buffer<double> converted;
            const ImageView<const double> frame = frames.frame(k, converted);
            for (size_t row = 0; row < frame.rows; row++)
                std::copy_n(frame.row(row), frame.cols, counts + row * frame.cols);
        };
        problem.frames.predictions = predictions_of(predictions, count, simulator);
        problem.windows = windows_of(problem.frames.predictions, window_days);
        if (problem.windows.size() * problem.free.size() > kMostUnknowns)
            fail(Status::argument, "{options->window_days} = %g: %zu windows of %zu parameters: must be at most %zu",
                 given.window_days, problem.windows.size(), problem.free.size(), kMostUnknowns);
        const calibrate::Point start = start_of(problem, outline, given.start);
        std::optional<Journal> journal;
        open_journal(journal, given.journal, "CALI", [&] { return calibrate::inputs_of(problem, outline, start); });
        std::optional<calibrate::Memo> memo;
        if (journal)
            problem.memo = &memo.emplace(*journal);
        made = new toliman_calibration{
            {}, improve ? calibrate::improve(problem, free, start, how) : calibrate::calibrate(problem, start, how)};
    });
}

void toliman_calibration_destroy(toliman_calibration *calibration) noexcept {
    destroy(calibration);
}

toliman_status toliman_calibration_get_info(const toliman_calibration *handle, toliman_calibration_info *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = use->calibration;
        const bool valid = has_values(calibration);
        toliman_calibration_info info = {};
        info.flags = calibration.underway ? calibrate::not_converged : calibration.flags;
        info.frames = static_cast<int64_t>(calibration.point.own.size());
        info.rows = static_cast<int64_t>(calibration.nominal.detector.rows);
        info.cols = static_cast<int64_t>(calibration.nominal.detector.cols);
        info.cells = static_cast<int64_t>(calibration.samples);
        info.parameters = static_cast<int64_t>(calibration.free.size());
        info.windows = static_cast<int64_t>(calibration.windows.size());
        info.iterations = calibration.iterations;
        info.map_iterations = calibration.map_iterations;
        // The chi-square is also that of a calibration that did not converge: it tells how far it came.
        set_goodness(calibration.goodness, info);
        info.structure = valid ? calibration.structure : kNan;
        info.structure_limit = valid ? calibration.structure_limit : kNan;
        info.separation_sigma_px = valid ? calibration.separation_sigma_px : kNan;
        info.calibration_sigma_px = valid ? calibration.calibration_sigma_px : kNan;
        info.map_rms_nm = valid ? 1e9 * calibration.map_rms_m : kNan;
        info.map_parameters = valid ? calibration.map_parameters : kNan;
        info.pupil_error = calibration.pupil_error;
        info.peak_noise = calibration.peak_noise;
        info.lacks = calibration.lacks;
        info.changes = calibration.improved;
        info.attempts = static_cast<int64_t>(calibration.attempts.size());
        info.left_out = static_cast<int64_t>(calibration.left_out.size());
        deliver(info, out, "out");
    });
}

toliman_status toliman_calibration_get_value(const toliman_calibration *handle, int64_t window, int64_t index,
                                             toliman_calibration_value *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = known(*handle, window);
        const size_t n = calibration.free.size(), i = required_index(index, n, "index"),
                     w = static_cast<size_t>(window), at = w * n + i;
        const Parameter parameter = calibration.free[i].parameter;
        const bool valid = has_values(calibration);
        toliman_calibration_value value = {};
        value.name = public_parameter(parameter).name;
        value.unit = unit_of(parameter);
        value.value = (calibration.flags & calibrate::not_converged) == 0 ? calibration.point.instrument[w][i] : kNan;
        value.sigma =
            valid ? std::sqrt(calibration.uncertainty.instrument[at * n * calibration.windows.size() + at]) : kNan;
        value.prior_sigma = calibration.free[i].sigma;
        if (valid && value.sigma > calibrate::kHeld * value.prior_sigma)
            value.flags |= TOLIMAN_CALIBRATION_HELD;
        if (calibration.even[i])
            value.flags |= TOLIMAN_CALIBRATION_NO_SIGN;
        deliver(value, out, "out");
    });
}

toliman_status toliman_calibration_get_covariance(const toliman_calibration *handle, int64_t window,
                                                  double *covariance) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = known(*handle, window);
        required(covariance, "covariance");
        const size_t n = calibration.free.size(), size = n * calibration.windows.size(),
                     first = static_cast<size_t>(window) * n;
        const bool valid = has_values(calibration);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++)
                covariance[i * n + j] =
                    valid ? calibration.uncertainty.instrument[(first + i) * size + first + j] : kNan;
    });
}

toliman_status toliman_calibration_get_frame(const toliman_calibration *handle, int64_t index,
                                             toliman_fit_result *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = use->calibration;
        const size_t i = required_index(index, calibration.point.own.size(), "index");
        fit::Result result;
        if (has_values(calibration))
            result = calibration.frames[i];
        else
            result.flags = fit::not_converged;
        deliver(public_result(result, calibrate::kOwn), out, "out");
    });
}

toliman_status toliman_calibration_get_window(const toliman_calibration *handle, int64_t window,
                                              toliman_calibration_window *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = known(*handle, window);
        const auto w = static_cast<size_t>(window);
        toliman_calibration_window found = {};
        found.frames = static_cast<int64_t>(calibration.windows[w].size());
        found.first_days = calibration.first_days[w];
        set_goodness(has_values(calibration) ? calibration.goodness_of[w] : Goodness(), found);
        deliver(found, out, "out");
    });
}

toliman_status toliman_calibration_get_attempt(const toliman_calibration *handle, int64_t index,
                                               toliman_calibration_attempt *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const auto &all = use->calibration.attempts;
        const calibrate::Attempt &attempt = all[required_index(index, all.size(), "index")];
        toliman_calibration_attempt tried = {};
        tried.change = attempt.lack;
        tried.kept = attempt.kept ? 1 : 0;
        tried.flags = attempt.flags;
        tried.cells = static_cast<int64_t>(attempt.samples);
        set_goodness(attempt.goodness, tried);
        deliver(tried, out, "out");
    });
}

toliman_status toliman_calibration_get_left_out(const toliman_calibration *handle, int64_t index,
                                                toliman_calibration_left_out *out) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const auto &all = use->calibration.left_out;
        const calibrate::LeftOut &left_out = all[required_index(index, all.size(), "index")];
        toliman_calibration_left_out found = {};
        found.name = public_parameter(left_out.parameter).name;
        found.reason = left_out.why;
        deliver(found, out, "out");
    });
}

toliman_status toliman_calibration_get_opd(const toliman_calibration *handle, int64_t window, double *opd) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = known(*handle, window);
        required(opd, "opd");
        const Buffer<double> change = calibrate::opd_change(calibration, static_cast<size_t>(window));
        const bool valid = has_values(calibration);
        for (size_t i = 0; i < change.size(); i++)
            opd[i] = valid ? change[i] : kNan;
    });
}

toliman_status toliman_calibration_get_image(const toliman_calibration *handle, int32_t kind, double *image,
                                             size_t stride) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = use->calibration;
        const Buffer<double> *const images[] = {&calibration.chi_map, &calibration.before, &calibration.after};
        const auto known = static_cast<size_t>(int64_t{kind} - TOLIMAN_CALIBRATION_IMAGE_CHI);
        if (known >= std::size(images))
            fail(Status::argument, "{kind} = %d: must be a constant TOLIMAN_CALIBRATION_IMAGE_...", kind);
        deliver_image(*images[known], calibration, image, stride);
    });
}

toliman_status toliman_calibration_save_file(const toliman_calibration *handle, int64_t window,
                                             const char *path) noexcept {
    return guard([&] {
        const Use use(handle, "calibration");
        const calibrate::Calibration &calibration = known(*handle, window);
        const std::string name = &required(path, "path");
        constexpr char suffix[] = ".json";
        const size_t length = sizeof suffix - 1;
        if (name.size() <= length || name.compare(name.size() - length, length, suffix) != 0)
            fail(Status::argument, "{path} = \"%s\": must end with .json", name.c_str());
        if ((calibration.flags & calibrate::not_converged) != 0)
            fail(Status::unsupported, "{calibration} did not converge: there is no fitted scene");
        const size_t slash = name.rfind('/');
        const std::string folder = slash == std::string::npos ? "." : name.substr(0, slash + 1),
                          stem = name.substr(0, name.size() - length) + ".opd.npy",
                          file = slash == std::string::npos ? stem : stem.substr(slash + 1);
        const Buffer<double> map = calibrate::fitted_map(calibration);
        const std::string &given = calibration.nominal.telescope.opd_file;
        std::error_code different;
        if (!map.empty() && !given.empty() && std::filesystem::equivalent(stem, given, different))
            fail(Status::argument, "{path} = \"%s\": its map would replace %s of the nominal scene", name.c_str(),
                 given.c_str());
        if (!map.empty()) {
            const std::string bytes = calibrate::npy_of(map, calibration.samples, calibration.samples);
            file::replace(stem, bytes.data(), bytes.size());
        }
        const std::string json =
            calibrate::fitted_json(calibration, static_cast<size_t>(window), folder, map.empty() ? "" : file);
        file::replace(name, json.data(), json.size());
    });
}
