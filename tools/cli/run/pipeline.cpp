// Method: stars at rest are measured by the network and the template, at microseconds a frame; stars that move by the
// fit and the networks of a bank, at milliseconds, because the others are made for the places at time 0. The frames of
// the cadence are estimated once, and each series is searched on the default grid. Frames without signal, at least 2000
// (200 for quick controls), give the scatter and the efficiency of each estimator, the latter to 1/sqrt(2 * 2000) = 1.6
// % (5 %). At rest their numbers follow those of the cadence. Moving stars are at their places in the frames of the
// cadence, whose numbers are therefore repeated with other seeds of noise and pointing.
#include "run/pipeline.hpp"

#include "common/parallel.hpp"
#include "frames/frame_loop.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

constexpr size_t kControlFrames = 2000;     // at least: efficiency to 1/sqrt(2 * 2000) = 1.6 %
constexpr size_t kQuickControlFrames = 200; // efficiency to 5 %

// The estimators of a run on its frames.
class Estimators {
  public:
    Estimators(const Scene &scene, const Cadence &cadence, const RunOptions &options, Progress &progress)
        : scene_(scene), cadence_(cadence), options_(options), progress_(progress) {
        if (!scene.moves())
            network_ =
                std::make_unique<NetworkRun>(scene, options.seed, cadence.times.size(), options.controls, progress);
    }

    // Trains the network, or creates the fit and its bank.
    void create(Timings &timings) {
        if (!network_) {
            const Stopwatch watch(timings.fit);
            fit_ = std::make_unique<FitRun>(scene_, options_.seed);
        }
        const Stopwatch watch(timings.train);
        if (network_)
            network_->train();
        else
            fit_->train(progress_);
    }

    void frames(Timings &timings) {
        const size_t total = cadence_.times.size();
        const auto work = [&](size_t at, size_t count, const double *images) {
            if (network_)
                network_->push(at, images, count);
            const Stopwatch watch(timings.fit);
            if (fit_)
                fit_->push(images, &cadence_.times[at], count);
            show("frames", at + count, total);
        };
        for_frames(scene_, options_.seed, 0, total, nullptr, work, &timings.simulate);
        if (network_)
            network_->end_frames();
        const Stopwatch watch(timings.fit);
        if (fit_)
            fit_->end_frames(cadence_.times);
    }

    // Returns the number of frames without signal.
    size_t controls(bool photon_noise) {
        const size_t signals = cadence_.times.size();
        const size_t total =
            options_.controls == Controls::full ? std::max(kControlFrames, signals) : kQuickControlFrames;
        std::vector<double> times;
        for (size_t k = 0; k < total; k++)
            times.push_back(cadence_.times[k % signals]);
        for_controls(total, [&](size_t at, size_t count, const double *images) {
            if (network_)
                network_->push_control(at, images, count);
            if (fit_)
                fit_->push(images, &times[at], count);
            show("controls", at + count, total);
        });
        if (network_)
            network_->end_controls(photon_noise);
        if (fit_)
            fit_->end_controls(photon_noise);
        return total;
    }

    void deliver(Pipeline &result) {
        if (network_) {
            result.network = std::move(network_->outcome);
            result.timings.encode = result.network->encode_seconds;
            result.timings.controls += result.network->reference_seconds;
        }
        if (!fit_)
            return;
        if (!fit_->has_series())
            throw Failure(kExitUsage,
                          formatted("%s: the fit did not converge for %zu of %zu frames: their noise must be smaller, "
                                    "and the stars must be in the frame",
                                    scene_.path.c_str(), fit_->outcome.lost, cadence_.times.size()));
        result.fit = std::move(fit_->outcome);
        if (fit_->has_bank())
            result.bank = std::move(fit_->bank_outcome);
    }

  private:
    void for_controls(size_t total, const FrameWork &work) const {
        const size_t signals = cadence_.times.size();
        const std::vector<double> still(total);
        if (network_)
            return for_frames(scene_, options_.seed, static_cast<int64_t>(signals), total, still.data(), work);
        for (size_t done = 0, round = 1; done < total; done += signals, round++)
            for_frames(scene_, options_.seed + (round << 32), 0, std::min(signals, total - done), still.data(),
                       [&](size_t at, size_t count, double *images) { work(done + at, count, images); });
    }

    void show(const char *stage, size_t done, size_t total) const {
        progress_.show(stage, static_cast<double>(done) / static_cast<double>(total));
    }

    const Scene &scene_;
    const Cadence &cadence_;
    const RunOptions &options_;
    Progress &progress_;
    std::unique_ptr<NetworkRun> network_; // null if the stars move
    std::unique_ptr<FitRun> fit_;         // null if they are at rest
};

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

Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, const RunOptions &options, double setup_seconds,
                      Progress &progress) {
    const StopLimit limit;
    Pipeline result;
    result.timings.setup = result.timings.total = setup_seconds;
    const Stopwatch total(result.timings.total);
    result.seed = options.seed;
    result.controls = options.controls;
    result.grid = default_grid(scene.path, cadence.times);
    result.photon_noise = scene.has("photon noise");
    if (!result.photon_noise && !scene.has("read noise"))
        throw Failure(kExitUsage,
                      scene.path + ": noise: run needs frames with noise: photon = true, or read_e above 0 e-");

    Estimators estimators(scene, cadence, options, progress);
    estimators.create(result.timings);
    estimators.frames(result.timings);
    if (options.controls != Controls::none) {
        const Stopwatch watch(result.timings.controls);
        result.control_frames = estimators.controls(result.photon_noise);
    }
    estimators.deliver(result);
    result.truth.power.resize(result.grid.nf);
    if (deviation(cadence.displacements) > 0)
        result.truth.values = cadence.displacements;
    const Stopwatch watch(result.timings.period);
    search_all(scene, cadence, result);
    return result;
}

} // namespace cli
