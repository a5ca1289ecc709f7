// include/toliman/calibrate.h
#include <toliman/calibrate.h>

#include "api/common.hpp"
#include "api/fit_values.hpp"
#include "api/handles.hpp"
#include "api/journal.hpp"
#include "api/parameters.hpp"
#include "api/pixel_frames.hpp"
#include "base/workers.hpp"
#include "calibrate/calibrate.hpp"
#include "calibrate/fitted.hpp"
#include "calibrate/improve.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/prior.hpp"
#include "calibrate/start.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_calibration : Handle<toliman_calibration> {
    static constexpr char kType[] = "toliman_calibration";
    calibrate::Calibration calibration;
};

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A calibration leaves out the same pixels of all frames, and has one response of each.
void check_windows(const PixelFrames &frames, size_t count, const Scene &scene, bool fits_response) {
    const Detector &detector = scene.detector;
    const KnownBadPixels bad(detector.rows, detector.cols, detector.bad_pixels, detector.window);
    for (size_t k = 0; frames.windows != nullptr && k < count; k++)
        if (const DetectorWindow window = *frames.window(k);
            bad.move_with(window) || detector.response_moves_with(window))
            fail(Status::unsupported,
                 "{image->windows}[%zu] = [%lld, %lld]: must be detector.window of %s, %s, or its "
                 "detector.bad_pixels or detector.response would move",
                 k, static_cast<long long>(window.row), static_cast<long long>(window.col), scene.source.c_str(),
                 detector.window_text().c_str());
    // The fitted response is that of the scene's window.
    for (size_t k = 0; frames.windows != nullptr && fits_response && k < count; k++)
        if (const DetectorWindow window = *frames.window(k); !(detector.window == window))
            fail(Status::unsupported,
                 "{image->windows}[%zu] = [%lld, %lld]: must be detector.window of %s, which a response needs", k,
                 static_cast<long long>(window.row), static_cast<long long>(window.col), scene.source.c_str());
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
        in_frame(k, [&] { predictions[k] = prediction_of(all.get(k), "predictions"); });
    return predictions;
}

const calibrate::Calibration &known(const toliman_calibration &handle, int64_t window) {
    required_index(window, handle.calibration.windows.size(), "window");
    return handle.calibration;
}

// start: may be NULL.
calibrate::Point start_of(const calibrate::Problem &problem, const optics::Outline &nominal, const toliman_sim *start) {
    return calibrate::start_of(problem, nominal, start != nullptr ? &Use(start, "options->start")->simulator : nullptr);
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
    step.is_response = report.of_response ? 1 : 0;
    TOLIMAN_COPY(step, report, iteration, accepted, chi_square, largest_step, recalled);
    step.change = report.lack;
    return step;
}

calibrate::Options options_of(const toliman_calibration_options &given) {
    calibrate::Options options;
    options.map = (given.flags & TOLIMAN_CALIBRATION_MAP) != 0;
    TOLIMAN_COPY(options, given, most_iterations, response_rms);
    options.map_rms_m = 1e-9 * given.map_rms_nm;
    options.response = (given.flags & TOLIMAN_CALIBRATION_DETECTOR) != 0;
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

// Of the pixels whose response the frames determine better than its prior.
void describe_response(const calibrate::Calibration &calibration, toliman_calibration_info &info) {
    const Buffer<double> &sigma = calibration.response_sigma;
    double square = 0;
    for (size_t i = 0; i < sigma.size(); i++)
        if (sigma[i] <= calibrate::kHeld * calibration.response_rms) {
            square += calibration.point.response[i] * calibration.point.response[i];
            info.response_pixels++;
        }
    info.response_rms = info.response_pixels > 0 ? std::sqrt(square / static_cast<double>(info.response_pixels)) : 0;
    info.response_parameters = calibration.response_parameters;
}

// Of the fitted response, with its standard deviation.
Buffer<double> response_image(const calibrate::Calibration &calibration, bool of_sigma) {
    const Buffer<double> &sigma = calibration.response_sigma;
    if (sigma.empty() || !calibration.has_values())
        return {};
    const std::vector<double> response = calibrate::fitted_response(calibration);
    Buffer<double> image(response.begin(), response.end());
    for (size_t i = 0; of_sigma && i < image.size(); i++)
        image[i] *= sigma[i] / (1 + calibration.point.response[i]);
    return image;
}

// Sums of frames whose stars move do not keep what is not linear in the charge.
void check_sums(const calibrate::Problem &problem) {
    for (const calibrate::Free &free : problem.free)
        if (problem.frames.has_sums() && (free.parameter.kind == Parameter::Kind::nonlinearity ||
                                          free.parameter.kind == Parameter::Kind::brighter_fatter))
            fail(Status::unsupported,
                 "{options->free}: \"%s\": sums of frames do not tell it: predictions must have no "
                 "spread",
                 name_of(free.parameter).c_str());
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
        calibrate::check_scene(simulator);
        if (count < 2)
            fail(Status::argument, "{count} = %zu: must be at least 2 frames", count);
        const bool improve = (given.flags & TOLIMAN_CALIBRATION_IMPROVE) != 0;
        calibrate::Options how = options_of(given);
        calibrate::Problem problem;
        problem.nominal = calibrate::with_photons(simulator);
        problem.settings.workers = worker_count(given.threads);
        problem.settings.progress = {given.progress, given.progress_data};
        if (improve && given.start != nullptr)
            how.improved =
                calibrate::adopt_cells(Use(given.start, "options->start")->simulator.scene(), problem.nominal);
        const optics::Outline outline = optics::outline_of(problem.nominal, problem.settings);
        problem.peak_photons = simulator.images().peak_photons();
        problem.peak_e =
            problem.peak_photons * problem.nominal.detector.qe / static_cast<double>(problem.nominal.detector.coadds);
        problem.frames.predictions = predictions_of(predictions, count, simulator);
        std::string free = given.free != nullptr ? given.free : "";
        if (how.response)
            free = calibrate::with_readout(free, problem.frames.has_sums());
        problem.free = calibrate::free_of(free, problem.nominal, outline.plan, problem.peak_e, &problem.left_out);
        check_sums(problem);
        TOLIMAN_COPY(problem, given, capture_px, smoothness);
        const PixelFrames frames =
            frames_of(image, count, simulator.scene().detector.rows, simulator.scene().detector.cols);
        check_windows(frames, count, simulator.scene(), how.response);
        problem.frames.count = count;
        problem.frames.read = [&frames](size_t k, double *counts) {
            Buffer<double> converted;
            const ImageView<const double> frame = frames.frame(k, converted);
            for (size_t row = 0; row < frame.rows; row++)
                std::copy_n(frame.row(row), frame.cols, counts + row * frame.cols);
        };
        if (how.map && problem.frames.has_sums())
            fail(Status::unsupported,
                 "{options->flags}: a map takes no sums of frames: predictions must have no spread");
        if (how.response && given.window_days > 0)
            fail(
                Status::unsupported,
                "{options->window_days} = %g: must be 0 with TOLIMAN_CALIBRATION_DETECTOR: the response is one for all "
                "frames",
                given.window_days);
        calibrate::set_windows(problem, given.window_days);
        if (problem.windows.size() * problem.free.size() > calibrate::kMostUnknowns)
            fail(Status::argument, "{options->window_days} = %g: %zu windows of %zu parameters: must be at most %zu",
                 given.window_days, problem.windows.size(), problem.free.size(), calibrate::kMostUnknowns);
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
    return query(handle, "calibration", out, [&](auto &self, auto &info) {
        const calibrate::Calibration &calibration = self.calibration;
        const bool valid = calibration.has_values();
        info.flags = calibration.underway ? calibrate::not_converged : calibration.flags;
        info.frames = static_cast<int64_t>(calibration.point.own.size());
        TOLIMAN_COPY(info, calibration.nominal.detector, rows, cols);
        info.cells = static_cast<int64_t>(calibration.samples);
        info.parameters = static_cast<int64_t>(calibration.free.size());
        info.windows = static_cast<int64_t>(calibration.windows.size());
        TOLIMAN_COPY(info, calibration, iterations, map_iterations);
        // The chi-square is also that of a calibration that did not converge: it tells how far it came.
        set_goodness(calibration.goodness, info);
        info.structure = valid ? calibration.structure : kNan;
        info.structure_limit = valid ? calibration.structure_limit : kNan;
        info.separation_sigma_px = valid ? calibration.separation_sigma_px : kNan;
        info.calibration_sigma_px = valid ? calibration.calibration_sigma_px : kNan;
        info.map_rms_nm = valid ? 1e9 * calibration.map_rms_m : kNan;
        info.response_iterations = calibration.response_iterations;
        describe_response(calibration, info);
        info.map_parameters = valid ? calibration.map_parameters : kNan;
        TOLIMAN_COPY(info, calibration, pupil_error, peak_noise, lacks);
        info.changes = calibration.improved;
        info.attempts = static_cast<int64_t>(calibration.attempts.size());
        info.left_out = static_cast<int64_t>(calibration.left_out.size());
    });
}

toliman_status toliman_calibration_get_value(const toliman_calibration *handle, int64_t window, int64_t index,
                                             toliman_calibration_value *out) noexcept {
    return query(handle, "calibration", out, [&](auto &self, auto &value) {
        const calibrate::Calibration &calibration = known(self, window);
        const size_t i = required_index(index, calibration.free.size(), "index"), w = static_cast<size_t>(window);
        const Parameter parameter = calibration.free[i].parameter;
        value.name = public_parameter(parameter).name;
        value.unit = unit_of(parameter);
        value.value = (calibration.flags & calibrate::not_converged) == 0 ? calibration.point.instrument[w][i] : kNan;
        value.sigma = std::sqrt(calibration.covariance(w, i, i));
        value.prior_sigma = calibration.free[i].sigma;
        if (value.sigma > calibrate::kHeld * value.prior_sigma)
            value.flags |= TOLIMAN_CALIBRATION_HELD;
        if (calibration.even[i])
            value.flags |= TOLIMAN_CALIBRATION_NO_SIGN;
    });
}

toliman_status toliman_calibration_get_covariance(const toliman_calibration *handle, int64_t window,
                                                  double *covariance) noexcept {
    return call(handle, "calibration", [&](auto &self) {
        const calibrate::Calibration &calibration = known(self, window);
        required(covariance, "covariance");
        const size_t n = calibration.free.size();
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++)
                covariance[i * n + j] = calibration.covariance(static_cast<size_t>(window), i, j);
    });
}

toliman_status toliman_calibration_get_frame(const toliman_calibration *handle, int64_t index,
                                             toliman_fit_result *out) noexcept {
    return call(handle, "calibration", [&](auto &self) {
        const calibrate::Calibration &calibration = self.calibration;
        const size_t i = required_index(index, calibration.point.own.size(), "index");
        fit::Result result;
        if (calibration.has_values())
            result = calibration.frames[i];
        else
            result.flags = fit::not_converged;
        deliver(public_result(result, calibrate::kOwn), out, "out");
    });
}

toliman_status toliman_calibration_get_window(const toliman_calibration *handle, int64_t window,
                                              toliman_calibration_window *out) noexcept {
    return query(handle, "calibration", out, [&](auto &self, auto &found) {
        const calibrate::Calibration &calibration = known(self, window);
        const auto w = static_cast<size_t>(window);
        found.frames = static_cast<int64_t>(calibration.windows[w].size());
        found.first_days = calibration.first_days[w];
        set_goodness(calibration.has_values() ? calibration.goodness_of[w] : Goodness(), found);
    });
}

toliman_status toliman_calibration_get_attempt(const toliman_calibration *handle, int64_t index,
                                               toliman_calibration_attempt *out) noexcept {
    return query(handle, "calibration", out, [&](auto &self, auto &tried) {
        const auto &all = self.calibration.attempts;
        const calibrate::Attempt &attempt = all[required_index(index, all.size(), "index")];
        tried.change = attempt.lack;
        TOLIMAN_COPY(tried, attempt, kept, flags);
        tried.cells = static_cast<int64_t>(attempt.samples);
        set_goodness(attempt.goodness, tried);
    });
}

toliman_status toliman_calibration_get_left_out(const toliman_calibration *handle, int64_t index,
                                                toliman_calibration_left_out *out) noexcept {
    return query(handle, "calibration", out, [&](auto &self, auto &found) {
        const auto &all = self.calibration.left_out;
        const calibrate::LeftOut &left_out = all[required_index(index, all.size(), "index")];
        found.name = public_parameter(left_out.parameter).name;
        found.reason = left_out.why;
    });
}

toliman_status toliman_calibration_get_opd(const toliman_calibration *handle, int64_t window, double *opd) noexcept {
    return call(handle, "calibration", [&](auto &self) {
        const calibrate::Calibration &calibration = known(self, window);
        required(opd, "opd");
        const Buffer<double> change = calibrate::opd_change(calibration, static_cast<size_t>(window));
        const bool valid = calibration.has_values();
        for (size_t i = 0; i < change.size(); i++)
            opd[i] = valid ? change[i] : kNan;
    });
}

toliman_status toliman_calibration_get_image(const toliman_calibration *handle, int32_t kind, double *image,
                                             size_t stride) noexcept {
    return call(handle, "calibration", [&](auto &self) {
        const calibrate::Calibration &calibration = self.calibration;
        switch (kind) {
        case TOLIMAN_CALIBRATION_IMAGE_CHI:
            return deliver_image(calibration.chi_map, calibration, image, stride);
        case TOLIMAN_CALIBRATION_IMAGE_BEFORE:
            return deliver_image(calibration.before, calibration, image, stride);
        case TOLIMAN_CALIBRATION_IMAGE_AFTER:
            return deliver_image(calibration.after, calibration, image, stride);
        case TOLIMAN_CALIBRATION_IMAGE_RESPONSE:
        case TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA:
            return deliver_image(response_image(calibration, kind == TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA),
                                 calibration, image, stride);
        default:
            fail(Status::argument, "{kind} = %d: must be a constant TOLIMAN_CALIBRATION_IMAGE_...", kind);
        }
    });
}

toliman_status toliman_calibration_save_file(const toliman_calibration *handle, int64_t window,
                                             const char *path) noexcept {
    return call(handle, "calibration", [&](auto &self) {
        const calibrate::Calibration &calibration = known(self, window);
        calibrate::save_fitted(calibration, static_cast<size_t>(window), &required(path, "path"));
    });
}
