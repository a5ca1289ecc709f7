#include "frames/estimator.hpp"

#include "common/stop.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

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

void EstimatorOptions::add_to(CLI::App &command) {
    // Not a CLI11 option group: it would report any mistyped word as a missing option.
    add_option(&command, "--weights", weights, "FILE", "weights file of `toliman train`: encode frames by its network");
    add_option(&command, "--template", scene, "SCENE",
               "instead of --weights: scene file; encode frames by least squares on its derivative image");
    add_option(&command, "--fit", fit, "SCENE",
               "instead of --weights: scene file; fit its forward model to each frame, which follows moving stars");
    add_option(&command, "--free", free, "NAMES",
               "with --fit: further free parameters, in quotes and separated by spaces, e.g. \"scale jitter_xx\"");
}

void EstimatorOptions::check() const {
    const int given = !weights.empty() + !scene.empty() + !fit.empty();
    if (given != 1)
        throw Failure(kExitUsage,
                      std::string("give ") + (given == 0 ? "one" : "only one") + " of --weights, --template and --fit");
    if (!free.empty() && fit.empty())
        throw Failure(kExitUsage, "--free " + free + ": needs --fit");
}

Estimator::Estimator(const EstimatorOptions &given, Progress &progress) {
    if (!given.weights.empty()) {
        network.emplace(given.weights);
        rows = network->info.rows;
        cols = network->info.cols;
        return;
    }
    const StopLimit limit;
    const Scene scene = given.fit.empty() ? Scene(given.scene, progress) : scene_to_fit(given.fit, progress);
    rows = scene.info.rows;
    cols = scene.info.cols;
    exposure_s = scene.info.exposure_s;
    if (given.fit.empty()) {
        const auto options = with_warnings<toliman_linear_options>(progress);
        linear = toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), &options);
    } else {
        fit = make_fit(scene, given.free, progress);
        times = Cadence(scene).times;
    }
}

} // namespace cli
