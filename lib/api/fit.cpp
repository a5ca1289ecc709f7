// include/toliman/fit.h
#include <toliman/fit.h>

#include "api/common.hpp"

#include <deque>

#include "api/fit_values.hpp"
#include "api/handles.hpp"
#include "api/parameters.hpp"
#include "api/pixel_frames.hpp"
#include "api/spread.hpp"
#include "api/track_estimators.hpp"
#include "base/text.hpp"
#include "base/workers.hpp"
#include "fit/self.hpp"
#include "frame/estimates.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

static_assert(fit::kMostParameters == TOLIMAN_FIT_MAX_PARAMETERS);

using Lease = WorkPool<fit::FitWork>::Lease;

// Checked options.
struct FitSettings {
    explicit FitSettings(const toliman_fit_options *options) {
        const toliman_fit_options known = accept(options, "options");
        threads = known.threads;
        free = parameters_of(known.free, "options->free", &self);
        capture_px = known.capture_px;
        memory = memory_of(known.allocator);
        progress = {known.progress, known.progress_data};
    }
    // All free parameters of fits of which this is the first scene.
    std::vector<Parameter> free_of(const optics::Simulator &simulator) const {
        std::vector<Parameter> all = free;
        if (self)
            for (const Parameter parameter : fit::self_parameters(simulator, free, worker_count(threads)))
                all.push_back(parameter);
        return all;
    }
    uint32_t threads;            // as given
    std::vector<Parameter> free; // those that are named
    bool self = false;
    double capture_px;
    Memory memory;
    Progress progress;
};

const optics::Simulator &simulator_of(const toliman_sim &sim, const char *name) {
    if (sim.simulator.plan().engine == optics::EngineKind::padded_fft)
        fail(Status::unsupported, "{%s}: the engine PADDED_FFT samples no images for a fit", name);
    return sim.simulator;
}

// Increasing starts of windows.
void check_starts(const double *first_days, size_t count) {
    if (count == 0)
        fail(Status::argument, "{count} = 0: must be at least 1");
    required(first_days, "first_days");
    for (size_t i = 0; i < count; i++) {
        if (!std::isfinite(first_days[i]))
            fail(Status::argument, "{first_days[%zu]} = %g: must be finite", i, first_days[i]);
        if (i > 0 && first_days[i] <= first_days[i - 1])
            fail(Status::argument, "{first_days[%zu]} = %g: must be above first_days[%zu] = %g", i, first_days[i],
                 i - 1, first_days[i - 1]);
    }
}

toliman_fit *make_fit(const std::vector<const optics::Simulator *> &simulators, const double *first_days,
                      const FitSettings &settings) {
    std::vector<optics::AtlasPlan> atlases;
    for (const optics::Simulator *simulator : simulators)
        atlases.push_back(simulator->plan().atlas);
    return new toliman_fit{{},
                           fit::Windows(simulators, first_days, settings.free_of(*simulators[0]), settings.capture_px,
                                        worker_count(settings.threads), settings.progress),
                           std::move(atlases),
                           settings.threads,
                           fit_source};
}

// The numbers of a frame that was not fitted are NaN.
void copy_parameters(const fit::Result &result, size_t n, double *values, double *covariance) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const bool fitted = (result.flags & fit::not_converged) == 0;
    for (size_t i = 0; values != nullptr && i < n; i++)
        values[i] = fitted ? result.values[i] : nan;
    for (size_t i = 0; covariance != nullptr && i < n * n; i++)
        covariance[i] = fitted ? result.covariance[i] : nan;
}

} // namespace

namespace toliman::api {

fit::Prediction prediction_of(const toliman_fit_prediction &given, const char *name) {
    if (given.flags != 0)
        fail(Status::argument, "{%s->flags} = %u: must be 0", name, given.flags);
    const std::pair<const char *, double> numbers[] = {{"time_days", given.time_days},
                                                       {"x_px", given.x_px},
                                                       {"y_px", given.y_px},
                                                       {"separation_px", given.separation_px},
                                                       {"position_angle_deg", given.position_angle_deg}};
    for (const auto &[member, number] : numbers)
        if (!std::isfinite(number))
            fail(Status::argument, "{%s->%s} = %g: must be finite", name, member, number);
    if (given.separation_px < 0)
        fail(Status::argument, "{%s->separation_px} = %g: must be above 0 px, or 0 for that of the scene", name,
             given.separation_px);
    return {given.time_days,
            {given.x_px, given.y_px},
            given.separation_px,
            given.position_angle_deg,
            given.spread != nullptr ? spread_of(given.spread, (std::string(name) + "->spread").c_str()) : Spread(),
            {}};
}

fit::Prediction prediction_of(const toliman_fit_prediction *given) {
    return given == nullptr ? fit::Prediction() : prediction_of(copied(given, "prediction"), "prediction");
}

fit::Prediction in_window(fit::Prediction prediction, const std::optional<DetectorWindow> &window) {
    prediction.window = window;
    return prediction;
}

fit::Prediction of_one_frame(const fit::Prediction &prediction, const char *name) {
    if (prediction.spread.any())
        fail(Status::unsupported, "{%s->spread}: must be NULL: banks take no sums of frames", name);
    return prediction;
}

toliman_fit_result public_result(const fit::Result &result, size_t n) {
    double values[fit::kMostParameters], covariance[fit::kMostParameters * fit::kMostParameters];
    copy_parameters(result, n, values, covariance);
    const auto sigma = [&](size_t i) { return std::sqrt(covariance[i * n + i]); };
    const bool fitted = (result.flags & fit::not_converged) == 0;
    toliman_fit_result out = {};
    out.flags = result.flags;
    out.displacement_px = fitted ? result.displacement_px : std::numeric_limits<double>::quiet_NaN();
    out.separation_px = values[0];
    out.separation_sigma_px = sigma(0);
    out.position_angle_deg = values[1];
    out.position_angle_sigma_deg = sigma(1);
    out.x_px = values[2];
    out.y_px = values[3];
    out.x_sigma_px = sigma(2);
    out.y_sigma_px = sigma(3);
    out.flux_a = values[4];
    out.flux_b = values[5];
    out.background = values[6];
    set_frame_goodness(fitted ? result.goodness : FrameGoodness(), out);
    TOLIMAN_COPY(out, result, iterations, excluded);
    return out;
}

} // namespace toliman::api

toliman_status toliman_fit_create(const toliman_sim *const *sims, const double *first_days, size_t count,
                                  const toliman_fit_options *options, toliman_fit **out) noexcept {
    return guard([&] {
        const FitSettings settings(options);
        const MemoryScope scope(settings.memory);
        required(sims, "sims");
        const double start = 0;
        const double *const starts = count == 1 && first_days == nullptr ? &start : first_days;
        check_starts(starts, count);
        std::deque<Use<const toliman_sim>> uses;
        std::vector<const optics::Simulator *> simulators;
        for (size_t i = 0; i < count; i++) {
            const std::string name = "sims[" + std::to_string(i) + "]";
            uses.emplace_back(sims[i], name.c_str());
            simulators.push_back(&simulator_of(*sims[i], name.c_str()));
        }
        toliman_fit *&made = required(out, "out");
        made = make_fit(simulators, starts, settings);
    });
}

void toliman_fit_destroy(toliman_fit *fit) noexcept {
    destroy(fit);
}

toliman_status toliman_fit_get_parameters(const toliman_fit *handle, toliman_sim_parameter *parameters, size_t capacity,
                                          size_t *count) noexcept {
    return call(handle, "fit", [&](auto &self) {
        const StructOutput<toliman_sim_parameter> result(parameters, "parameters", capacity, count);
        const std::vector<Parameter> &all = self.fit.parameters();
        result.write(all.size(), "parameters", [&](size_t i) {
            toliman_sim_parameter found = public_parameter(all[i]);
            if (all[i].kind == Parameter::Kind::position_angle)
                found.unit = "deg";
            return found;
        });
    });
}

toliman_status toliman_fit_get_info(const toliman_fit *handle, toliman_fit_info *out) noexcept {
    return query(handle, "fit", out, [&](auto &self, auto &info) {
        const fit::Windows &fit = self.fit;
        for (const optics::AtlasPlan &atlas : self.atlases) {
            info.oversampling = std::max(info.oversampling, static_cast<uint32_t>(atlas.oversampling));
            info.taps = std::max(info.taps, static_cast<uint32_t>(atlas.blur.window.taps));
            info.image_error = std::max(info.image_error, atlas.error);
        }
        info.rows = static_cast<int64_t>(fit.rows());
        info.cols = static_cast<int64_t>(fit.cols());
        info.images = static_cast<uint32_t>(fit.images());
        info.parameters = static_cast<int64_t>(fit.parameters().size());
        info.capture_px = fit.capture_px();
        info.digest = fit.digest();
    });
}

toliman_status toliman_fit_frame(const toliman_fit *handle, const toliman_image *image, size_t count,
                                 const toliman_fit_prediction *predictions, toliman_fit_result *results, double *values,
                                 double *covariance) noexcept {
    return call(handle, "fit", [&](auto &self) {
        const fit::Windows &fit = self.fit;
        if (count == 0)
            return;
        const PixelFrames frames = frames_of(image, count, fit.rows(), fit.cols());
        const StructArray<toliman_fit_result> out(results, "results");
        const Predictions given(predictions);
        const size_t n = fit.parameters().size();
        if (count == 1) {
            Buffer<double> converted;
            Lease work(self.works);
            fit::Result found;
            fit.frame(frames.frame(0, converted), in_window(given.at(0), frames.window(0)), *work, found);
            out.put(0, public_result(found, n));
            return copy_parameters(found, n, values, covariance);
        }
        Buffer<toliman_fit_result> found(count); // so that nothing is written if a frame fails
        Buffer<double> found_values(values != nullptr ? checked_product(count, n, "values") : 0),
            found_covariance(covariance != nullptr ? checked_product(count, n * n, "covariance") : 0);
        for_groups(
            frames, count, 1, self.threads, [&] { return fit.work(); },
            [&](const ImageView<const double> *frame, size_t i, size_t, fit::FitWork &work) {
                fit::Result result;
                fit.frame(*frame, in_window(given.at(i), frames.window(i)), work, result);
                found[i] = public_result(result, n);
                copy_parameters(result, n, values != nullptr ? &found_values[i * n] : nullptr,
                                covariance != nullptr ? &found_covariance[i * n * n] : nullptr);
            });
        for (size_t i = 0; i < count; i++)
            out.put(i, found[i]);
        std::copy(found_values.begin(), found_values.end(), values);
        std::copy(found_covariance.begin(), found_covariance.end(), covariance);
    });
}

toliman_status toliman_fit_predict(const toliman_fit *handle, const toliman_fit_prediction *prediction, double *image,
                                   size_t stride, double *values, double *covariance) noexcept {
    return call(handle, "fit", [&](auto &self) {
        if (image != nullptr)
            required_image(image, stride, self.fit.cols(), "image");
        Lease work(self.works);
        const fit::Prediction known = prediction_of(prediction);
        const std::shared_ptr<const fit::Fit> fit = self.fit.at(known);
        if (image != nullptr)
            fit->expect(known, {image, fit->rows(), fit->cols(), stride}, *work);
        if (image != nullptr && values == nullptr && covariance == nullptr)
            return; // the image alone takes half of the time
        fit::Result found;
        fit->predict(known, *work, found);
        copy_parameters(found, fit->parameters().size(), values, covariance);
    });
}
