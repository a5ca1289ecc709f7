#include "experiment.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "failure.hpp"

namespace cli {

namespace {

constexpr size_t kFramesAtOnce = 48;
constexpr size_t kControlFrames = 2000;   // efficiency is known to 1/sqrt(2 * 2000) = 1.6 %
constexpr double kLeastShare = 0.9;       // of the counted variance, for an efficiency that means something
constexpr size_t kValidationFrames = 110; // as many as the chapter's validation set

using toliman::check;

class Stopwatch {
  public:
    explicit Stopwatch(double &sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
    ~Stopwatch() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Stopwatch(const Stopwatch &) = delete;
    Stopwatch &operator=(const Stopwatch &) = delete;

  private:
    double &sum_;
    std::chrono::steady_clock::time_point start_;
};

double deviation(const std::vector<double> &values) {
    double mean = 0, square = 0;
    for (double value : values)
        mean += value / static_cast<double>(values.size());
    for (double value : values)
        square += (value - mean) * (value - mean);
    return std::sqrt(square / static_cast<double>(values.size() - 1));
}

// Variance of the frames over the one that the Cramer-Rao bound counts, mean over pixels; 0 without noise, below 1
// where a scene draws no photon noise.
double noise_share(const Scene &scene, uint64_t seed) {
    constexpr size_t frames = 16, pairs = frames / 2;
    const size_t pixels = scene.pixels();
    const std::vector<double> still(frames, 0.0);
    std::vector<double> images(frames * pixels), variance(pixels);
    check(toliman_sim_frame_many(scene.sim.get(), seed, 0, frames, still.data(), 0, images.data()));
    check(toliman_sim_get_image(scene.sim.get(), TOLIMAN_IMAGE_VARIANCE, variance.data(),
                                static_cast<size_t>(scene.info.cols)));
    double found = 0, counted = 0;
    for (size_t i = 0; i < pixels; i++) {
        counted += variance[i] * pairs;
        for (size_t k = 0; k < pairs; k++) {
            const double gap = images[2 * k * pixels + i] - images[(2 * k + 1) * pixels + i];
            found += gap * gap / 2;
        }
    }
    return found / counted;
}

// Estimators of one scene and the frames they are tried on.
class Bench {
  public:
    Bench(const Scene &scene, uint64_t seed, Progress &progress)
        : scene_(scene), seed_(seed), progress_(progress),
          cae_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, nullptr)),
          untrained_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, nullptr)),
          linear_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get())) {}

    void train(Experiment &result) {
        const Stopwatch watch(result.timings.train);
        toliman_cae_train_options options;
        toliman_cae_train_options_init(&options);
        options.progress = Progress::callback;
        options.progress_data = &progress_;
        result.training.struct_size = sizeof result.training;
        check(toliman_cae_train(cae_.get(), &options, &result.training));
    }

    // (decode(z) - decode(0))/z against what it should be; a dead decoder also reaches the photon floor.
    void inspect_decoder(Experiment &result) const {
        constexpr size_t side = 256;
        const double z = scene_.info.crb_px;
        std::vector<double> target(side * side), at_z(target.size()), at_0(target.size());
        check(toliman_cae_get_target(cae_.get(), target.data(), side));
        check(toliman_cae_decode(cae_.get(), z, at_z.data(), side));
        check(toliman_cae_decode(cae_.get(), 0, at_0.data(), side));
        double product = 0, target_square = 0, painted_square = 0;
        for (size_t i = 0; i < target.size(); i++) {
            const double painted = (at_z[i] - at_0[i]) / z;
            product += painted * target[i];
            target_square += target[i] * target[i];
            painted_square += painted * painted;
        }
        result.decoder_cosine = product / std::sqrt(target_square * painted_square);
        result.decoder_gain = product / target_square;
    }

    void signal_frames(const Cadence &cadence, Experiment &result, std::vector<double> &untrained) const {
        const size_t total = cadence.times.size();
        result.latents.resize(total);
        result.estimates.resize(total);
        untrained.resize(total);
        result.validation_frames = std::min(total, kValidationFrames);
        for_frames("frames", 0, total, nullptr, result.timings.simulate, [&](size_t at, size_t count) {
            {
                const Stopwatch watch(result.timings.encode);
                check(toliman_cae_encode_many(cae_.get(), images_.data(), count, 0, &result.latents[at]));
            }
            const Stopwatch watch(result.timings.controls);
            check(toliman_cae_encode_many(untrained_.get(), images_.data(), count, 0, &untrained[at]));
            estimate(count, &result.estimates[at]);
            for (size_t i = 0; i < count && at + i < result.validation_frames; i++)
                reconstruct(i, result);
        });
    }

    // Frames without signal, numbered on from the cadence's last.
    void control_frames(const Cadence &cadence, Experiment &result, std::vector<double> &latents,
                        std::vector<double> &estimates, std::vector<double> &untrained) const {
        const Stopwatch watch(result.timings.controls);
        const size_t total = result.control_frames = std::max(kControlFrames, cadence.times.size());
        latents.resize(total);
        estimates.resize(total);
        untrained.resize(std::min(total, cadence.times.size()));
        const std::vector<double> still(kFramesAtOnce, 0.0);
        double seconds = 0;
        for_frames("controls", cadence.times.size(), total, still.data(), seconds, [&](size_t at, size_t count) {
            check(toliman_cae_encode_many(cae_.get(), images_.data(), count, 0, &latents[at]));
            estimate(count, &estimates[at]);
            if (at < untrained.size())
                check(toliman_cae_encode_many(untrained_.get(), images_.data(), std::min(count, untrained.size() - at),
                                              0, &untrained[at]));
        });
    }

  private:
    template <class Work>
    void for_frames(const char *stage, size_t first, size_t total, const double *displacements, double &seconds,
                    Work work) const {
        images_.resize(std::min(total, kFramesAtOnce) * scene_.pixels());
        for (size_t done = 0; done < total;) {
            const size_t count = std::min(kFramesAtOnce, total - done);
            {
                const Stopwatch watch(seconds);
                check(toliman_sim_frame_many(scene_.sim.get(), seed_, static_cast<int64_t>(first + done), count,
                                             displacements, 0, images_.data()));
            }
            work(done, count);
            done += count;
            progress_.show(stage, static_cast<double>(done) / static_cast<double>(total));
            stop_if_asked();
        }
    }

    void estimate(size_t count, double *values) const {
        for (size_t i = 0; i < count; i++)
            check(toliman_linear_encode(linear_.get(), image(i), cols(), &values[i]));
    }

    void reconstruct(size_t i, Experiment &result) const {
        constexpr size_t side = 256;
        std::vector<double> painted(side * side);
        double mmse, mssim, floor;
        check(toliman_cae_reconstruct(cae_.get(), image(i), cols(), painted.data(), side, &mmse, &mssim, &floor));
        const auto share = 1 / static_cast<double>(result.validation_frames);
        result.mmse += mmse * share;
        result.mssim += mssim * share;
        result.photon_floor += floor * share;
    }

    const double *image(size_t i) const { return images_.data() + i * scene_.pixels(); }
    size_t cols() const { return static_cast<size_t>(scene_.info.cols); }

    const Scene &scene_;
    uint64_t seed_;
    Progress &progress_;
    toliman::autoencoder cae_, untrained_;
    toliman::linear_estimator linear_;
    mutable std::vector<double> images_; // one chunk of frames
};

} // namespace

Experiment run_experiment(const Scene &scene, const Cadence &cadence, uint64_t seed, double setup_seconds,
                          Progress &progress) {
    Experiment result;
    result.timings.setup = result.timings.total = setup_seconds;
    const Stopwatch total(result.timings.total);
    result.seed = seed;
    result.grid = default_grid({scene.path, cadence.times, {}, {}});
    const double share = noise_share(scene, seed);
    if (share == 0)
        throw Failure(kExitUsage,
                      scene.path + ": noise: run needs frames with noise: photon true, or read_e above 0 e-");

    Bench bench(scene, seed, progress);
    bench.train(result);
    bench.inspect_decoder(result);
    std::vector<double> untrained, blank_latents, blank_estimates, blank_untrained;
    bench.signal_frames(cadence, result, untrained);
    bench.control_frames(cadence, result, blank_latents, blank_estimates, blank_untrained);
    result.latent.sigma_px = result.no_signal.sigma_px = deviation(blank_latents);
    result.estimate.sigma_px = deviation(blank_estimates);
    result.untrained.sigma_px = deviation(blank_untrained);
    result.efficiency = share > kLeastShare ? scene.info.crb_projected_px / result.latent.sigma_px : NAN;

    const auto peak_of = [&](const std::vector<double> &values) {
        return find_period({scene.path, cadence.times, values, {}}, result.grid, false, progress).peak;
    };
    {
        const Stopwatch watch(result.timings.period);
        const Periodogram periodogram =
            find_period({scene.path, cadence.times, result.latents, {}}, result.grid, false, progress);
        result.latent.peak = periodogram.peak;
        result.power = power_of(periodogram, result.grid.nf);
    }
    const Stopwatch watch(result.timings.controls);
    blank_latents.resize(cadence.times.size());
    result.no_signal.peak = peak_of(blank_latents);
    result.estimate.peak = peak_of(result.estimates);
    result.untrained.peak = peak_of(untrained);
    return result;
}

} // namespace cli
