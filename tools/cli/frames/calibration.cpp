#include "frames/calibration.hpp"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/library.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "frames/predictions.hpp"
#include "frames/scene_fit.hpp"

namespace cli {

namespace {

constexpr char kSuffix[] = ".json";
constexpr int32_t kIterations = 30; // the default

// Fields of the library's messages, and the options that set them.
constexpr std::pair<const char *, const char *> kOptions[] = {{"options->free", "--free"},
                                                              {"options->start", "--resume"},
                                                              {"options->window_days", "--windows"},
                                                              {"options->capture_px", "--capture"}};

std::optional<Scene> start_of(const CalibrationRequest &request, const CalibrationFiles &files, Progress &progress) {
    if (!request.resume)
        return std::nullopt;
    if (exists(files.part()))
        return scene_to_calibrate(files.part(), progress);
    if (!exists(files.out()))
        throw Failure(kExitUsage, "--resume: neither " + files.part() + " nor " + files.out() + " exists");
    return scene_to_calibrate(windows_of(files.out())[0].scene, progress);
}

} // namespace

CalibrationFiles::CalibrationFiles(const std::string &out) : out_(out) {
    if (!ends_with(out, kSuffix) || out.size() == sizeof kSuffix - 1 || ends_with(out, std::string("/") + kSuffix))
        throw Failure(kExitUsage, "--out " + out + ": must be the name of a file that ends in .json");
    stem_ = out.substr(0, out.size() - (sizeof kSuffix - 1));
}

std::string CalibrationFiles::scene(size_t window, size_t windows) const {
    return windows == 1 ? out_ : stem_ + "." + std::to_string(window + 1) + kSuffix;
}

void CalibrationFiles::remove_part() const {
    std::error_code error;
    for (const char *suffix : {".part.json", ".part.opd.npy"})
        std::filesystem::remove(with_suffix(suffix), error);
}

FrameSet::FrameSet(const FrameOptions &options, const Scene &scene, Progress &progress) {
    const Cadence cadence(scene);
    Predictions times(cadence.times, 1, {options.cadence, {}, LeapSeconds()}, progress);
    for (const std::string &path : options.files) {
        const auto file = options.open(path);
        if (file->rows() != static_cast<size_t>(scene.info.rows) ||
            file->cols() != static_cast<size_t>(scene.info.cols))
            malformed(file->path(), "frames of " + shape_text(file->rows(), file->cols()) + ": the scene is for " +
                                        shape_text(scene.info.rows, scene.info.cols));
        times.open(*file);
        for (size_t k = 0; file->more(); k++) {
            pixels.resize(pixels.size() + scene.pixels());
            file->read_finite(&pixels[pixels.size() - scene.pixels()]);
            places.push_back({path, k});
            predictions.push_back(*times.from(k, 1));
            progress.note("read", std::to_string(places.size()) + " frames");
            stop_if_asked();
        }
    }
    if (places.size() < 2)
        malformed(options.files[0], "has " + std::to_string(places.size()) +
                                        " frame: a calibration needs at least 2, and about 10 for accurate optics");
}

std::string FrameSet::name(size_t i) const {
    return places[i].file + ": frame " + std::to_string(places[i].frame);
}

Calibration::Calibration(const CalibrationRequest &request, const CalibrationFiles &files, Progress &progress)
    : request_(request), files_(files), scene_(scene_to_calibrate(request.scene, progress, request.bad_pixels)),
      frames_(request.frames, scene_, progress) {}

// A state that was rejected is not saved: the last one is better. A calibration with windows resumes with the first.
int32_t Calibration::on_step(const toliman_calibration *so_far, const toliman_calibration_step *step, void *self) {
    Calibration &run = *static_cast<Calibration *>(self);
    run.steps_.push_back(*step);
    const std::string change =
        step->change != 0 ? toliman_calibration_change_name(step->change) + std::string(": ") : "";
    run.progress_->line("calibrate", formatted("%s%s iteration %d: chi-square %.6g, largest step %.3g %s%s",
                                               change.c_str(), step->map != 0 ? "map" : "parameters", step->iteration,
                                               step->chi_square, step->largest_step, step->map != 0 ? "nm" : "sigma",
                                               step->accepted != 0 ? "" : ", rejected"));
    if (step->accepted != 0 && toliman_calibration_save_file(so_far, 0, run.files_.part().c_str()) != TOLIMAN_OK)
        run.failure_ = toliman_last_error();
    return !run.failure_.empty() || stop_signal() != 0 ? 1 : 0;
}

void Calibration::run(Progress &progress) {
    // Iterations may take a minute. What they save is replaced atomically.
    const StopLimit limit("stopped by a signal; if an iteration was complete, --resume continues after it");
    progress_ = &progress;
    const std::optional<Scene> start = start_of(request_, files_, progress);
    toliman_calibration_options options = request_.options;
    options.free = request_.by_free ? request_.free.c_str() : nullptr;
    options.start = start ? start->sim.get() : nullptr;
    options.step = on_step;
    options.step_data = this;
    const toliman_image image = plain_image(frames_.pixels.data());
    try {
        made_ = toliman::make<toliman::scene_calibration>(toliman_calibrate, scene_.sim.get(), &image,
                                                          frames_.places.size(), frames_.predictions.data(), &options);
    } catch (const toliman::error &error) {
        refuse(error);
    }
    progress.clear();
    const auto info = info_from<toliman_calibration_info>(toliman_calibration_get_info, made_.get());
    if ((info.flags & TOLIMAN_CALIBRATION_NOT_CONVERGED) != 0)
        fail_to_converge(info);
}

// An error of the library in terms of files and options.
void Calibration::refuse(const toliman::error &error) const {
    std::string why = error.what();
    if (!failure_.empty())
        throw Failure(kExitOutput, failure_);
    if (error.status() == TOLIMAN_E_CANCELLED) {
        if (exists(files_.part()))
            progress_->tell("the state is in " + files_.part() + "; the same command with --resume continues from it");
        stop_if_asked();
    }
    for (const auto &[field, option] : kOptions)
        if (error.field() == field)
            why.replace(why.find(field), std::string(field).size(), option);
    const std::string of_frame = "frame ";
    if (error.status() == TOLIMAN_E_ARGUMENT && why.rfind(of_frame, 0) == 0) {
        const size_t colon = why.find(": ");
        const size_t frame = std::strtoul(why.c_str() + of_frame.size(), nullptr, 10);
        if (colon != std::string::npos && frame < frames_.places.size())
            malformed(frames_.name(frame), why.substr(colon + 2));
    }
    if (error.field().empty() || why == error.what())
        throw error;
    throw Failure(kExitUsage, why);
}

bool Calibration::reached_limit(const toliman_calibration_info &info) const {
    const int32_t most = request_.options.most_iterations != 0 ? request_.options.most_iterations : kIterations;
    return info.iterations >= most || info.map_iterations >= most;
}

// A state from which more iterations may converge is kept.
void Calibration::fail_to_converge(const toliman_calibration_info &info) const {
    std::string why = files_.out() + ": not written: the calibration did not converge: chi-square " +
                      formatted("%.4g", info.chi_square) + " after " +
                      std::to_string(info.iterations + info.map_iterations) + " iterations: ";
    if (reached_limit(info) && exists(files_.part()))
        throw Failure(kExitRejected,
                      why + "the same command with --resume and more --iterations continues from " + files_.part());
    files_.remove_part();
    throw Failure(kExitRejected,
                  why + "is the scene that of the frames (times, places of the stars, mask, band, photons)?");
}

} // namespace cli
