// Method: train a network on the scene (no frames), encode the frames of the cadence once by the trained network, the
// untrained network and the template estimator, and search each series on the default grid. Frames without signal, at
// least 2000 with numbers after the cadence, give the scatter of each estimator; efficiency is the Cramer-Rao bound
// over that of the latent, known to 1/sqrt(2 * 2000) = 1.6 %. The decoder is checked against the whitened derivative
// image, because a decoder that ignores the latent also reaches the photon floor of the reconstruction error.
#include "experiment/pipeline.hpp"

#include <algorithm>
#include <cmath>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/stopwatch.hpp"
#include "frames/frame_loop.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

constexpr size_t kControlFrames = 2000; // at least: efficiency to 1/sqrt(2 * 2000) = 1.6 %
constexpr uint32_t kSteps = 300;        // the library's default

using toliman::check;

// The estimators of one scene and the frames that they encode.
class Estimators {
  public:
    Estimators(const Scene &scene, uint64_t seed, Progress &progress)
        : scene_(scene), seed_(seed), progress_(progress),
          cae_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, nullptr)),
          untrained_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, nullptr)),
          linear_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr)) {}

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
        const double z = scene_.info.crb_px;
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

    void signal_frames(const Cadence &cadence, Pipeline &result, std::vector<double> &untrained) const {
        const size_t total = cadence.times.size();
        result.latents.resize(total);
        result.estimates.resize(total);
        untrained.resize(total);
        Reconstructor reconstructor(scene_, cae_, seed_, total);
        const auto work = [&](size_t at, size_t count, const double *images) {
            const toliman_image image = plain_image(images);
            {
                const Stopwatch watch(result.timings.encode);
                check(toliman_cae_encode_many(cae_.get(), &image, count, 0, &result.latents[at], nullptr));
            }
            const Stopwatch watch(result.timings.controls);
            check(toliman_cae_encode_many(untrained_.get(), &image, count, 0, &untrained[at], nullptr));
            estimate(images, count, &result.estimates[at]);
            for (size_t i = 0; i < count; i++)
                reconstructor.take(at + i, images + i * scene_.pixels());
            show("frames", at + count, total);
        };
        for_frames(scene_, seed_, 0, total, nullptr, work, &result.timings.simulate);
        result.reconstructions = reconstructor.result();
    }

    // Frames without signal; their numbers follow those of the cadence.
    void control_frames(const Cadence &cadence, Pipeline &result, std::vector<double> &latents,
                        std::vector<double> &estimates, std::vector<double> &untrained) const {
        const Stopwatch watch(result.timings.controls);
        const size_t total = result.control_frames = std::max(kControlFrames, cadence.times.size());
        latents.resize(total);
        estimates.resize(total);
        untrained.resize(std::min(total, cadence.times.size()));
        const std::vector<double> still(total, 0.0);
        const auto work = [&](size_t at, size_t count, const double *images) {
            const toliman_image image = plain_image(images);
            check(toliman_cae_encode_many(cae_.get(), &image, count, 0, &latents[at], nullptr));
            estimate(images, count, &estimates[at]);
            if (at < untrained.size())
                check(toliman_cae_encode_many(untrained_.get(), &image, std::min(count, untrained.size() - at), 0,
                                              &untrained[at], nullptr));
            show("controls", at + count, total);
        };
        for_frames(scene_, seed_, static_cast<int64_t>(cadence.times.size()), total, still.data(), work);
    }

  private:
    void show(const char *stage, size_t done, size_t total) const {
        progress_.show(stage, static_cast<double>(done) / static_cast<double>(total));
    }

    void estimate(const double *images, size_t count, double *values) const {
        const toliman_image image = plain_image(images);
        check(toliman_linear_encode_many(linear_.get(), &image, count, 0, values, nullptr));
    }

    const Scene &scene_;
    uint64_t seed_;
    Progress &progress_;
    toliman::autoencoder cae_, untrained_;
    toliman::linear_estimator linear_;
};

} // namespace

Pipeline run_pipeline(const Scene &scene, const Cadence &cadence, uint64_t seed, double setup_seconds,
                      Progress &progress) {
    Pipeline result;
    result.timings.setup = result.timings.total = setup_seconds;
    const Stopwatch total(result.timings.total);
    result.seed = seed;
    result.grid = default_grid({scene.path, cadence.times, {}, {}});
    const double share = noise_share(scene, seed);
    if (share == 0)
        throw Failure(kExitUsage,
                      scene.path + ": noise: run needs frames with noise: photon = true, or read_e above 0 e-");

    Estimators estimators(scene, seed, progress);
    estimators.train(result);
    estimators.inspect_decoder(result);
    std::vector<double> untrained, blank_latents, blank_estimates, blank_untrained;
    estimators.signal_frames(cadence, result, untrained);
    estimators.control_frames(cadence, result, blank_latents, blank_estimates, blank_untrained);
    result.latent.sigma_px = result.no_signal.sigma_px = deviation(blank_latents);
    result.estimate.sigma_px = deviation(blank_estimates);
    result.untrained.sigma_px = deviation(blank_untrained);
    result.efficiency = share > kLeastShare ? scene.info.crb_projected_px / result.latent.sigma_px : NAN;

    const auto searched = [&](const std::vector<double> &values) {
        return find_period({scene.path, cadence.times, values, {}}, result.grid, {}, progress);
    };
    {
        const Stopwatch watch(result.timings.period);
        const Periodogram periodogram = searched(result.latents);
        result.latent.peak = periodogram.peak;
        result.power = power_of(periodogram.handle.get(), result.grid.nf);
        result.false_alarm_power = power_at_fap_1e_3(periodogram.handle.get());
    }
    const Stopwatch watch(result.timings.controls);
    blank_latents.resize(cadence.times.size());
    const Periodogram of_template = searched(result.estimates);
    result.estimate.peak = of_template.peak;
    result.estimate_power = power_of(of_template.handle.get(), result.grid.nf);
    result.no_signal.peak = searched(blank_latents).peak;
    result.untrained.peak = searched(untrained).peak;
    result.true_power.resize(result.power.size());
    if (deviation(cadence.displacements) > 0) {
        const Periodogram of_truth = searched(cadence.displacements);
        result.truth.peak = of_truth.peak;
        result.true_power = power_of(of_truth.handle.get(), result.grid.nf);
    }
    return result;
}

} // namespace cli
