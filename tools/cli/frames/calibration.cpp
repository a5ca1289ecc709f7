#include "frames/calibration.hpp"

#include <cstdlib>
#include <filesystem>

#include "common/job_journal.hpp"
#include "frames/predictions.hpp"
#include "frames/scene_fit.hpp"
#include "scenes/scene_defaults.hpp"

namespace cli {

namespace {

constexpr char kSuffix[] = ".json";
constexpr int32_t kIterations = 30; // the default

} // namespace

CalibrationFiles::CalibrationFiles(const std::string &out) : out_(out) {
    if (!ends_with(out, kSuffix) || out.size() == sizeof kSuffix - 1 || ends_with(out, std::string("/") + kSuffix))
        throw Failure(kExitUsage, "--out " + out + ": must be the name of a file that ends in .json");
    stem_ = out.substr(0, out.size() - (sizeof kSuffix - 1));
}

std::string CalibrationFiles::scene(size_t window, size_t windows) const {
    return windows == 1 ? out_ : stem_ + "." + std::to_string(window + 1) + kSuffix;
}

Calibration::Calibration(const CalibrationRequest &request, const CalibrationFiles &files, Progress &progress)
    : request_(request), files_(files), scene_(scene_to_calibrate(request.scene, progress, request.bad_pixels)),
      frames_(request.frames, scene_, {request.most_frames, request.options.window_days}, progress) {}

// Iterations of the journal have their lines in the earlier output.
int32_t Calibration::on_step(const toliman_calibration *, const toliman_calibration_step *step, void *self) {
    Calibration &run = *static_cast<Calibration *>(self);
    const bool resumes = step->recalled == 0 && !run.steps_.empty() && run.steps_.back().recalled != 0;
    if (resumes)
        run.progress_->tell(formatted("continues after iteration %d, chi-square %.6g, of %s",
                                      run.steps_.back().iteration, run.steps_.back().chi_square,
                                      run.files_.journal().c_str()));
    run.steps_.push_back(*step);
    const std::string change =
        step->change != 0 ? toliman_constant_name(static_cast<int32_t>(step->change)) + std::string(": ") : "";
    if (step->recalled == 0)
        run.progress_->line("calibrate",
                            formatted("%s%s iteration %d: chi-square %.6g, largest step %.3g %s%s", change.c_str(),
                                      step->is_map != 0        ? "map"
                                      : step->is_response != 0 ? "response"
                                                               : "parameters",
                                      step->iteration, step->chi_square, step->largest_step,
                                      step->is_map != 0 ? "nm" : "sigma", step->accepted != 0 ? "" : ", rejected"));
    return stop_signal() != 0 ? 1 : 0;
}

toliman::scene_calibration Calibration::calibrated(const toliman_sim *start) {
    const std::string journal = files_.journal();
    toliman_calibration_options options = request_.options;
    options.free = request_.by_free ? request_.free.c_str() : nullptr;
    options.start = start;
    options.journal = journal.c_str();
    options.step = on_step;
    options.step_data = this;
    options.progress = Progress::callback;
    options.progress_data = progress_;
    toliman_image image = plain_image(frames_.pixels.data());
    image.windows = frames_.windows.empty() ? nullptr : frames_.windows[0].data();
    return toliman::make<toliman::scene_calibration>(toliman_calibration_create, scene_.sim.get(), &image,
                                                     frames_.places.size(), frames_.predictions.data(), &options);
}

// With --resume a calibration without a journal starts from the scene that --out holds, if there is one. A journal may
// be that of a calibration that did, or of one without --resume: the library tells by its start.
void Calibration::run(Progress &progress) {
    // Iterations may take a minute. Each is in the journal once it is complete.
    const StopLimit limit("stopped by a signal; if an iteration was complete, --resume continues after it");
    progress_ = &progress;
    std::optional<Scene> start;
    if (request_.resume && exists(files_.out()))
        start.emplace(scene_to_calibrate(windows_of(files_.out())[0].scene, progress));
    const bool may_differ = start && exists(files_.journal());
    try {
        try {
            made_ = calibrated(start ? start->sim.get() : nullptr);
        } catch (const toliman::error &error) {
            if (!may_differ || error.status() != TOLIMAN_E_MISMATCH || error.field() != files_.journal())
                throw;
            made_ = calibrated(nullptr);
        }
    } catch (const toliman::error &error) {
        refuse(error);
    }
    progress.clear();
    const auto info = toliman::result<toliman_calibration_info>(toliman_calibration_get_info, made_.get());
    if ((info.flags & TOLIMAN_CALIBRATION_NOT_CONVERGED) != 0)
        fail_to_converge(info);
}

// An error of the library in terms of files and options.
void Calibration::refuse(const toliman::error &error) const {
    const std::string why = error.what();
    if (error.status() == TOLIMAN_E_CANCELLED) {
        if (exists(files_.journal()))
            progress_->tell("the same command with --resume continues from " + files_.journal());
        stop_if_asked();
    }
    if (error.field() == files_.journal())
        refuse_journal(error);
    refuse_option(
        error, {{"free", "--free"}, {"start", "--resume"}, {"window_days", "--windows"}, {"capture_px", "--capture"}});
    const std::string of_frame = "frame ";
    if (error.status() == TOLIMAN_E_ARGUMENT && why.rfind(of_frame, 0) == 0) {
        const size_t colon = why.find(": ");
        const size_t frame = std::strtoul(why.c_str() + of_frame.size(), nullptr, 10);
        if (colon != std::string::npos && frame < frames_.places.size())
            malformed(frames_.name(frame), why.substr(colon + 2));
    }
    throw error;
}

bool Calibration::reached_limit(const toliman_calibration_info &info) const {
    const int32_t most = request_.options.most_iterations != 0 ? request_.options.most_iterations : kIterations;
    return info.iterations >= most || info.map_iterations >= most || info.response_iterations >= most;
}

// A journal from which more iterations may converge is kept.
void Calibration::fail_to_converge(const toliman_calibration_info &info) const {
    std::string why = files_.out() + ": not written: the calibration did not converge: chi-square " +
                      formatted("%.4g", info.chi_square) + " after " +
                      std::to_string(info.iterations + info.map_iterations + info.response_iterations) +
                      " iterations: ";
    if (reached_limit(info))
        throw Failure(kExitRejected,
                      why + "the same command with --resume and more --iterations continues from " + files_.journal());
    remove_journal(files_.journal());
    throw Failure(kExitRejected,
                  why + "is the scene that of the frames (times, places of the stars, mask, band, photons)?");
}

} // namespace cli
