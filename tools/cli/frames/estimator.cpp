#include "frames/estimator.hpp"

#include "frames/scene_fit.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

// A file of the other kind, which needs other options.
void check_weights(const EstimatorOptions &given) {
    const Content content = identify(given.weights).content;
    refuse_mistakes({{content == Content::bank && given.fit.empty(),
                      given.weights + ": is a bank of networks, which follow the fit of a scene: add --fit with the "
                                      "scene of the training, and its --free"},
                     {content == Content::weights && !given.fit.empty(),
                      given.weights + ": is a single network, for stars at rest: leave out --fit, or give --weights a "
                                      "bank of networks (`toliman train --bank`)"}});
}

} // namespace

void EstimatorOptions::add_to(CLI::App &command) {
    // Not a CLI11 option group: it would report any mistyped word as a missing option.
    add_option(&command, "--weights", weights, "FILE");
    add_option(&command, "--template", scene, "SCENE");
    add_option(&command, "--fit", fit, "SCENE");
    add_option(&command, "--free", free, "NAMES");
    add_bad_pixels(command, bad_pixels);
}

void EstimatorOptions::check() const {
    refuse_mistakes(
        {{weights.empty() && scene.empty() && fit.empty(), "give one of --weights, --template and --fit"},
         {!scene.empty() && !(weights.empty() && fit.empty()),
          "give only one of --weights, --template and --fit, or --fit with the --weights of a bank"},
         {!free.empty() && fit.empty(), "--free " + free + ": needs --fit"},
         {!bad_pixels.empty() && scene.empty() && fit.empty(),
          "--bad-pixels " + bad_pixels +
              ": needs --fit or --template: a network has those of its training (`toliman train --bad-pixels`)"}});
}

Estimator::Estimator(const EstimatorOptions &given, Progress &progress) {
    if (!given.weights.empty())
        check_weights(given);
    if (!given.fit.empty()) {
        set_fit(given, progress);
        return;
    }
    if (!given.weights.empty()) {
        network.emplace(given.weights);
        rows = network->info.rows;
        cols = network->info.cols;
        return;
    }
    const StopLimit limit;
    const Scene made(given.scene, progress, given.bad_pixels);
    use_scene(made);
    const auto options = with_warnings<toliman_linear_options>(progress);
    linear = toliman::make<toliman::linear_estimator>(toliman_linear_create, made.sim.get(), &options);
}

void Estimator::use_scene(const Scene &made) {
    rows = made.info.rows;
    cols = made.info.cols;
    scene = scene_defaults(made.path);
    cadence_days = span_days(made);
    bit_depth = static_cast<uint32_t>(made.info.bit_depth);
    time_zero_ns = made.info.time_zero_ns;
}

void Estimator::set_fit(const EstimatorOptions &given, Progress &progress) {
    const StopLimit limit;
    if (!given.weights.empty())
        bank = trained_bank(given.weights);
    SceneFit made =
        fit_of_scene(given.fit, given.free, given.bad_pixels, progress, given.self_by_default && given.weights.empty());
    use_scene(made.scene);
    times = Cadence(made.scene).times;
    if (given.weights.empty() && made.scene.info.calibration == TOLIMAN_SIM_CALIBRATION_NONE)
        lacks = made.scene.lacks_for_real_frames();
    pixel_scale_arcsec = made.scene.info.pixel_scale_arcsec;
    moves = made.scene.moves();
    fit = std::move(made.fit);
    if (bank) {
        check_bank(bank, fit, given.weights, given.fit, given.free);
        renewal = renewal_of(bank, fit, made.scene, given.fit, given.free);
    }
}

} // namespace cli
