// Method: train a network on the scene (no frames), encode the frames of the cadence once by the trained network, the
// untrained network and the template estimator, and search each series on the default grid. Frames without signal, at
// least 2000 (200 for quick controls) with numbers after the cadence, give the scatter of each estimator; efficiency is
// the Cramer-Rao bound over that of the latent, known to 1/sqrt(2 * 2000) = 1.6 % (5 %). The decoder is checked against
// the whitened derivative image, because a decoder that ignores the latent also reaches the photon floor of the
// reconstruction error.
#include "experiment/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/parallel.hpp"
#include "common/stop.hpp"
#include "experiment/methods.hpp"
#include "frames/frame_loop.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

constexpr size_t kControlFrames = 2000;     // at least: efficiency to 1/sqrt(2 * 2000) = 1.6 %
constexpr size_t kQuickControlFrames = 200; // efficiency to 5 %
constexpr uint32_t kSteps = 300;            // the library's default

using toliman::check;

toliman::autoencoder network_of(const Scene &scene, uint64_t seed, Progress &progress) {
    const auto options = with_warnings<toliman_cae_options>(progress);
    return toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, &options);
}

// The estimators of one scene and the frames that they encode.
class Estimators {
  public:
    Estimators(const Scene &scene, uint64_t seed, Controls controls, Progress &progress)
        : scene_(scene), seed_(seed), controls_(controls), progress_(progress), cae_(network_of(scene, seed, progress)),
          template_(method_kind("template").make(scene, seed, shared_)) {
        if (controls != Controls::none)
            untrained_ = method_kind("untrained").make(scene, seed, shared_);
    }

    void train(Pipeline &result) {
        const Stopwatch watch(result.timings.train);
        auto options = toliman::sized<toliman_cae_train_options>();
        options.progress = Progress::callback;
        options.progress_data = &progress_;
        result.losses.resize(kSteps);
        options.steps = kSteps;
        options.losses = result.losses.data();
        options.loss_count = kSteps;
        result.training.struct_size = sizeof result.training;
        check(toliman_cae_train(cae_.get(), &options, &result.training));
        result.weights = bytes_of([this](unsigned char *data, size_t capacity, size_t *size) {
            return toliman_cae_save(cae_.get(), nullptr, data, capacity, size);
        });
    }

    // Compares (decode(z) - decode(0))/z with the whitened derivative image, which it should be.
    void inspect_decoder(Pipeline &result) const {
        constexpr size_t side = 256;
        const double z = scene_.bounds().crb_px;
        std::vector<double> target(side * side), at_z(target.size()), at_0(target.size());
        check(toliman_cae_get_target(cae_.get(), target.data(), side));
        check(toliman_cae_decode(cae_.get(), z, at_z.data(), side));
        check(toliman_cae_decode(cae_.get(), 0, at_0.data(), side));
        double product = 0, target_square = 0, output_square = 0;
        for (size_t i = 0; i < target.size(); i++) {
            const double output = (at_z[i] - at_0[i]) / z;
            product += output * target[i];
            target_square += target[i] * target[i];
            output_square += output * output;
        }
        result.decoder_cosine = product / std::sqrt(target_square * output_square);
        result.decoder_gain = product / target_square;
    }

    // Returns the values of the untrained network, none without controls.
    std::vector<double> signal_frames(const Cadence &cadence, Pipeline &result) const {
        const size_t total = cadence.times.size();
        Reconstructor reconstructor(scene_, cae_, seed_, total);
        const auto work = [&](size_t at, size_t count, const double *images) {
            {
                const Stopwatch encoding(result.timings.encode);
                encode(images, count, result.latents);
            }
            const Stopwatch watch(result.timings.controls);
            if (untrained_)
                untrained_->push(images, count);
            template_->push(images, count);
            reconstructor.take(at, images, count);
            show("frames", at + count, total);
        };
        for_frames(scene_, seed_, 0, total, nullptr, work, &result.timings.simulate);
        result.reconstructions = reconstructor.result();
        result.estimates = template_->series();
        return untrained_ ? untrained_->series() : std::vector<double>{};
    }

    // Frames without signal; their numbers follow those of the cadence. Returns their latents, at most as many as the
    // cadence has frames.
    std::vector<double> control_frames(const Cadence &cadence, Pipeline &result) const {
        const Stopwatch watch(result.timings.controls);
        const size_t signals = cadence.times.size();
        const size_t total = result.control_frames =
            controls_ == Controls::full ? std::max(kControlFrames, signals) : kQuickControlFrames;
        std::vector<double> latents;
        const auto work = [&](size_t at, size_t count, const double *images) {
            encode(images, count, latents);
            template_->push(images, count);
            if (at < signals)
                untrained_->push(images, std::min(count, signals - at));
            show("controls", at + count, total);
        };
        for_frames(scene_, seed_, static_cast<int64_t>(signals), total, std::vector<double>(total).data(), work);
        result.latent.sigma_px = result.no_signal.sigma_px = deviation(latents);
        result.estimate.sigma_px = deviation(template_->series());
        result.untrained.sigma_px = deviation(untrained_->series());
        latents.resize(std::min(signals, total));
        return latents;
    }

  private:
    void show(const char *stage, size_t done, size_t total) const {
        progress_.show(stage, static_cast<double>(done) / static_cast<double>(total));
    }

    void encode(const double *images, size_t count, std::vector<double> &latents) const {
        const toliman_image image = plain_image(images);
        latents.resize(latents.size() + count);
        check(toliman_cae_encode_many(cae_.get(), &image, count, 0, &latents[latents.size() - count], nullptr));
    }

    const Scene &scene_;
    uint64_t seed_;
    Controls controls_;
    Progress &progress_;
    toliman::autoencoder cae_;
    SharedFrames shared_;
    std::unique_ptr<Method> template_, untrained_; // without controls there is no untrained network
};

// Searches the series of values, which belong to the first times of the cadence, for its period.
void search(const Scene &scene, const Cadence &cadence, const std::vector<double> &values, const FrequencyGrid &grid,
            Outcome &outcome) {
    Progress quiet(Progress::Style::none);
    const std::vector<double> times(cadence.times.begin(),
                                    cadence.times.begin() + static_cast<std::ptrdiff_t>(values.size()));
    const Periodogram periodogram = find_period({scene.path, times, values, {}}, grid, {}, quiet);
    outcome.peak = periodogram.peak;
    outcome.power = power_of(periodogram.handle.get(), grid.nf);
    outcome.power_at_fap_1e_3 = power_at_fap_1e_3(periodogram.handle.get());
}

} // namespace

Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, const RunOptions &options, double setup_seconds,
                      const std::function<void()> &while_training, Progress &progress) {
    const StopLimit limit;
    Pipeline result;
    result.timings.setup = result.timings.total = setup_seconds;
    const Stopwatch total(result.timings.total);
    result.seed = options.seed;
    result.controls = options.controls;
    result.grid = default_grid({scene.path, cadence.times, {}, {}});
    const double share = noise_share(scene, options.seed);
    if (share == 0)
        throw Failure(kExitUsage,
                      scene.path + ": noise: run needs frames with noise: photon = true, or read_e above 0 e-");
    result.photon_noise = share > kLeastShare;

    Estimators estimators(scene, options.seed, options.controls, progress);
    run_parallel(2, [&](size_t job) { job == 0 ? estimators.train(result) : while_training(); });
    estimators.inspect_decoder(result);
    const std::vector<double> untrained = estimators.signal_frames(cadence, result);
    std::vector<double> without_signal;
    if (options.controls != Controls::none)
        without_signal = estimators.control_frames(cadence, result);
    if (result.photon_noise)
        result.efficiency = scene.bounds().crb_projected_px / result.latent.sigma_px;

    result.truth.power.resize(result.grid.nf);
    std::vector<std::pair<const std::vector<double> *, Outcome *>> searches = {{&result.latents, &result.latent},
                                                                               {&result.estimates, &result.estimate}};
    if (options.controls != Controls::none) {
        searches.emplace_back(&without_signal, &result.no_signal);
        searches.emplace_back(&untrained, &result.untrained);
    }
    if (deviation(cadence.displacements) > 0)
        searches.emplace_back(&cadence.displacements, &result.truth);
    const Stopwatch watch(result.timings.period);
    run_parallel(searches.size(),
                 [&](size_t i) { search(scene, cadence, *searches[i].first, result.grid, *searches[i].second); });
    return result;
}

} // namespace cli
