// Method: stars at rest are measured by the network and the template, at microseconds a frame; stars that move by the
// fit and the networks of a bank, at milliseconds, because the others are made for the places at time 0. The frames of
// the cadence are estimated once, and each series is searched on the default grid. Frames without signal, at least 2000
// (200 for quick controls), give the scatter and the efficiency of each estimator, the latter to 1/sqrt(2 * 2000) = 1.6
// % (5 %). At rest their numbers follow those of the cadence. Moving stars are at their places in the frames of the
// cadence, whose numbers are therefore repeated with other seeds of noise and pointing.
#include "run/pipeline.hpp"

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "common/parallel.hpp"
#include "frames/frame_loop.hpp"
#include "run/estimators.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

constexpr size_t kControlFrames = 2000;     // at least: efficiency to 1/sqrt(2 * 2000) = 1.6 %
constexpr size_t kQuickControlFrames = 200; // efficiency to 5 %

const std::vector<std::string> kNames = {"none", "quick", "full"}; // in the order of Controls

void show(Progress &progress, const char *stage, size_t done, size_t total) {
    progress.show(stage, static_cast<double>(done) / static_cast<double>(total));
}

void push_frames(const Scene &scene, size_t total, Estimators &estimators, Pipeline &result, Progress &progress) {
    const auto work = [&](size_t at, size_t count, const double *images) {
        estimators.push(at, images, count);
        show(progress, "frames", at + count, total);
    };
    for_frames(scene, result.options.seed, 0, total, nullptr, work, &result.timings.simulate);
    estimators.end_frames();
}

// signals: number of frames of the cadence.
void push_controls(const Scene &scene, size_t signals, Estimators &estimators, Pipeline &result, Progress &progress) {
    const Stopwatch watch(result.timings.controls);
    const uint64_t seed = result.options.seed;
    const size_t total =
        result.options.controls == Controls::full ? std::max(kControlFrames, signals) : kQuickControlFrames;
    const std::vector<double> still(total);
    const auto work = [&](size_t at, size_t count, const double *images) {
        estimators.push_control(at, images, count);
        show(progress, "controls", at + count, total);
    };
    if (result.network)
        for_frames(scene, seed, static_cast<int64_t>(signals), total, still.data(), work);
    for (size_t done = 0, round = 1; !result.network && done < total; done += signals, round++)
        for_frames(scene, seed + (round << 32), 0, std::min(signals, total - done), still.data(),
                   [&](size_t at, size_t count, double *images) { work(done + at, count, images); });
    estimators.end_controls();
    result.control_frames = total;
}

// Searches the values, which belong to the first times of the cadence, for their period.
void search(const Scene &scene, const Cadence &cadence, const FrequencyGrid &grid, Outcome &outcome) {
    Progress quiet(Progress::Style::none);
    std::vector<double> times, values;
    for (size_t k = 0; k < outcome.values.size(); k++) {
        if (std::isnan(outcome.values[k]))
            continue;
        times.push_back(cadence.times[k]);
        values.push_back(outcome.values[k]);
    }
    const Periodogram periodogram = find_period(series_of(scene.path, times, values).get(), grid, {}, quiet);
    outcome.peak = periodogram.peak;
    outcome.power = power_of(periodogram.handle.get(), grid.nf);
    outcome.power_at_fap_1e_3 = power_at_fap_1e_3(periodogram.handle.get());
}

// Searches all series that have values.
void search_all(const Scene &scene, const Cadence &cadence, Pipeline &result) {
    std::vector<Outcome *> outcomes = {&result.truth};
    if (result.network)
        for (Outcome NetworkOutcome::*part : {&NetworkOutcome::latent, &NetworkOutcome::template_fit,
                                              &NetworkOutcome::untrained, &NetworkOutcome::no_signal})
            outcomes.push_back(&((*result.network).*part));
    if (result.fit)
        outcomes.insert(outcomes.end(), {&result.fit->signal, &result.fit->no_signal});
    if (result.bank)
        outcomes.insert(outcomes.end(), {&result.bank->signal, &result.bank->no_signal});
    outcomes.erase(
        std::remove_if(outcomes.begin(), outcomes.end(), [](const Outcome *one) { return one->values.empty(); }),
        outcomes.end());
    run_parallel(outcomes.size(), [&](size_t i) { search(scene, cadence, result.grid, *outcomes[i]); });
}

} // namespace

std::string name_of(Controls controls) {
    return kNames[static_cast<size_t>(controls)];
}

void add_controls(CLI::App &command, Controls &controls) {
    const auto set = [&controls](const std::string &word) {
        controls = static_cast<Controls>(std::find(kNames.begin(), kNames.end(), word) - kNames.begin());
    };
    command.add_option_function<std::string>("--controls", set)->check(CLI::IsMember(kNames));
}

Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, const RunOptions &options, double setup_seconds,
                      Progress &progress) {
    const StopLimit limit;
    Pipeline result;
    result.timings.setup = result.timings.total = setup_seconds;
    const Stopwatch total(result.timings.total);
    result.options = options;
    result.grid = default_grid(scene.path, cadence.times);
    result.photon_noise = scene.has("photon noise");
    if (!result.photon_noise && !scene.has("read noise"))
        throw Failure(kExitUsage,
                      scene.path + ": noise: run needs frames with noise: photon = true, or read_e above 0 e-");

    const auto estimators = make_estimators(scene, cadence, result, progress);
    {
        const Stopwatch watch(result.timings.train);
        estimators->train();
    }
    push_frames(scene, cadence.times.size(), *estimators, result, progress);
    if (options.controls != Controls::none)
        push_controls(scene, cadence.times.size(), *estimators, result, progress);
    estimators->require_series();
    result.truth.power.resize(static_cast<size_t>(result.grid.nf));
    if (deviation(cadence.displacements) > 0)
        result.truth.values = cadence.displacements;
    const Stopwatch watch(result.timings.period);
    search_all(scene, cadence, result);
    return result;
}

} // namespace cli
