// Method: train a network on the scene (no frames) and encode each frame by the trained network, the untrained network
// and the template estimator. Frames without signal give the scatter of each estimator; efficiency is the Cramer-Rao
// bound over that of the latent. The decoder is checked against the whitened derivative image, because a decoder that
// ignores the latent also reaches the photon floor of the reconstruction error.
#include "run/network_run.hpp"

#include "common/parallel.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr size_t kValidationFrames = 110; // size of the book chapter's validation set

using toliman::check;

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

Reconstructor::Reconstructor(const Scene &scene, const toliman::autoencoder &cae, size_t total)
    : scene_(scene), cae_(cae) {
    const auto info = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae.get(), nullptr);
    side_ = info.side;
    crop_row_ = static_cast<size_t>(info.crop_row);
    crop_col_ = static_cast<size_t>(info.crop_col);
    sigma_ = cropped(scene.image(TOLIMAN_SIM_IMAGE_VARIANCE).data());
    for (double &pixel : sigma_)
        pixel = std::sqrt(pixel);
    result_.validation_frames = std::min(total, kValidationFrames);
}

// The part of a frame that the network sees.
Reconstructor::Image Reconstructor::cropped(const double *image) const {
    const auto cols = static_cast<size_t>(scene_.info.cols);
    Image part;
    part.reserve(side_ * side_);
    for (size_t row = 0; row < side_; row++) {
        const double *start = image + (crop_row_ + row) * cols + crop_col_;
        part.insert(part.end(), start, start + side_);
    }
    return part;
}

void Reconstructor::add_residual(const Image &residual) {
    double sum = 0, square = 0, product = 0;
    for (size_t i = 0; i < residual.size(); i++) {
        sum += residual[i];
        square += residual[i] * residual[i];
        product += (i + 1) % side_ != 0 ? residual[i] * residual[i + 1] : 0;
    }
    const auto frames = static_cast<double>(result_.validation_frames), side = static_cast<double>(side_),
               pixels = side * side;
    result_.residual_mean += sum / (pixels * frames);
    result_.residual_square += square / (pixels * frames);
    result_.residual_product += product / ((pixels - side) * frames);
}

void Reconstructor::take(size_t first, const double *images, size_t count) {
    if (first >= result_.validation_frames)
        return;
    std::vector<Reconstruction> all(std::min(count, result_.validation_frames - first));
    run_parallel(all.size(), [&](size_t i) { reconstruct(images + i * scene_.pixels(), all[i]); });
    for (const Reconstruction &one : all) // in order, so that the sums have the same bits for any number of threads
        add(one);
}

void Reconstructor::reconstruct(const double *image, Reconstruction &result) const {
    Image again(side_ * side_);
    check(toliman_cae_reconstruct(cae_.get(), image, static_cast<size_t>(scene_.info.cols), again.data(), side_,
                                  &result.mmse, &result.mssim, &result.photon_floor));
    result.residual = cropped(image);
    for (size_t i = 0; i < again.size(); i++)
        result.residual[i] = (result.residual[i] - again[i]) / sigma_[i];
}

void Reconstructor::add(const Reconstruction &one) {
    const auto share = 1 / static_cast<double>(result_.validation_frames);
    result_.mmse += one.mmse * share;
    result_.mssim += one.mssim * share;
    result_.photon_floor += one.photon_floor * share;
    add_residual(one.residual);
}

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
