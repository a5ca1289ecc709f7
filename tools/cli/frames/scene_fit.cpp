#include "frames/scene_fit.hpp"

#include "common/failure.hpp"
#include "common/stop.hpp"

namespace cli {

namespace {

// Omits warnings: those about a scene concern simulated frames and estimators for stars at rest, not a fit.
void log_news(int32_t level, const char *text, void *progress) {
    if (level != TOLIMAN_LOG_WARNING)
        Progress::log(level, text, progress);
}

Scene scene_to_fit(const std::string &file, Progress &progress) {
    auto options = toliman::sized<toliman_sim_options>();
    options.progress = Progress::callback;
    options.progress_data = options.log_data = &progress;
    options.log = log_news;
    return Scene(file, options);
}

toliman::frame_fit make_fit(const Scene &scene, const std::string &free, Progress &progress) {
    const StopLimit limit;
    auto options = toliman::sized<toliman_fit_options>();
    options.free = free.c_str();
    options.progress = Progress::callback;
    options.progress_data = &progress;
    toliman_fit *made = nullptr;
    const toliman_status status = toliman_fit_create(scene.sim.get(), &options, &made);
    const std::string field = "options->free";
    if (status != TOLIMAN_OK && toliman_last_error_field() == field) {
        std::string why = toliman_last_error();
        throw Failure(kExitUsage, why.replace(why.find(field), field.size(), "--free"));
    }
    toliman::check(status);
    return toliman::frame_fit(made);
}

} // namespace

SceneFit::SceneFit(const std::string &file, const std::string &free, Progress &progress)
    : scene(scene_to_fit(file, progress)), fit(make_fit(scene, free, progress)) {}

} // namespace cli
