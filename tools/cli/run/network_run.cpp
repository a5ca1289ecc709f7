// Method: train a network on the scene (no frames) and encode each frame by the trained network, the untrained network
// and the template estimator. Frames without signal give the scatter of each estimator; efficiency is the Cramer-Rao
// bound over that of the latent. The decoder is checked against the whitened derivative image, because a decoder that
// ignores the latent also reaches the photon floor of the reconstruction error.
#include "run/network_run.hpp"

#include <algorithm>

#include "common/library.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr uint32_t kSteps = 300; // the library's default

using toliman::check;

toliman::autoencoder network_of(const Scene &scene, uint64_t seed, const toliman_cae_options *options) {
    return toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, options);
}

// Appends the values of frames. encode: toliman_cae_encode or toliman_linear_encode.
template <class Encode, class Estimator>
void add_values(Encode encode, const Estimator &estimator, const double *images, size_t count,
                std::vector<double> &values) {
    const toliman_image image = plain_image(images);
    values.resize(values.size() + count);
    check(encode(estimator.get(), &image, count, &values[values.size() - count], nullptr));
}

} // namespace

NetworkRun::NetworkRun(const Scene &scene, uint64_t seed, size_t frames, Controls controls, Progress &progress)
    : scene_(scene), frames_(frames), progress_(progress), options_(with_warnings<toliman_cae_options>(progress)),
      cae_(network_of(scene, seed, &options_)),
      template_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr)),
      reconstructor_(scene, cae_, frames) {
    if (controls != Controls::none)
        untrained_ = network_of(scene, seed, nullptr);
}

void NetworkRun::train() {
    auto options = toliman::sized<toliman_cae_train_options>();
    options.progress = Progress::callback;
    options.progress_data = &progress_;
    outcome.losses.resize(kSteps);
    options.steps = kSteps;
    options.losses = outcome.losses.data();
    options.loss_count = kSteps;
    outcome.training.struct_size = sizeof outcome.training;
    check(toliman_cae_train(cae_.get(), &options, &outcome.training));
    outcome.weights = bytes_of([this](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_cae_save(cae_.get(), nullptr, data, capacity, size);
    });
    inspect_decoder();
}

// Compares (decode(z) - decode(0))/z with the whitened derivative image, which it should be.
void NetworkRun::inspect_decoder() {
    const double z = scene_.bounds().crb_px;
    const size_t side = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae_.get(), nullptr).side;
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
    outcome.decoder_cosine = product / std::sqrt(target_square * output_square);
    outcome.decoder_gain = product / target_square;
}

void NetworkRun::push(size_t at, const double *images, size_t count) {
    {
        const Stopwatch watch(outcome.encode_seconds);
        add_values(toliman_cae_encode, cae_, images, count, outcome.latent.values);
    }
    const Stopwatch watch(outcome.reference_seconds);
    if (untrained_)
        add_values(toliman_cae_encode, untrained_, images, count, outcome.untrained.values);
    add_values(toliman_linear_encode, template_, images, count, outcome.template_fit.values);
    reconstructor_.take(at, images, count);
}

void NetworkRun::push_control(size_t at, const double *images, size_t count) {
    add_values(toliman_cae_encode, cae_, images, count, outcome.no_signal.values);
    add_values(toliman_linear_encode, template_, images, count, template_controls_);
    if (at < frames_)
        add_values(toliman_cae_encode, untrained_, images, std::min(count, frames_ - at), untrained_controls_);
}

void NetworkRun::end_frames() {
    outcome.reconstructions = reconstructor_.result();
}

void NetworkRun::end_controls(bool photon_noise) {
    std::vector<double> &latents = outcome.no_signal.values;
    outcome.latent.sigma_px = outcome.no_signal.sigma_px = deviation(latents);
    outcome.template_fit.sigma_px = deviation(template_controls_);
    outcome.untrained.sigma_px = deviation(untrained_controls_);
    if (photon_noise)
        outcome.efficiency = scene_.bounds().crb_projected_px / outcome.latent.sigma_px;
    latents.resize(std::min(frames_, latents.size()));
}

} // namespace cli
