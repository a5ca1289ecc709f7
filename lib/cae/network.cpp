#include "cae/network.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/workers.hpp"
#include "kernels/elu.hpp"

namespace toliman::cae {

namespace {

constexpr double kLargestLatent = 1e6; // px; beyond it float32 could overflow on the way

Packed pack(const Parameters &parameters) {
    Packed packed;
    for (size_t s = 0; s < kStages; s++) {
        const kernels::ConvShape &shape = kFlight.stages[s];
        packed.down[s].resize(shape.packed());
        packed.up[s].resize(shape.packed());
        kernels::conv_pack_down(shape, parameters[conv_weight(s)], 0.25f, packed.down[s].data());
        kernels::conv_pack_up(shape, parameters[deconv_weight(s)], 1.0f, packed.up[s].data());
    }
    return packed;
}

// Sum of products in double, eight partial sums in fixed order.
double dense(const float *a, const float *b, size_t count) noexcept {
    double part[8] = {};
    for (size_t i = 0; i < count; i += 8)
        for (size_t k = 0; k < 8; k++)
            part[k] += static_cast<double>(a[i + k]) * static_cast<double>(b[i + k]);
    return ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
}

} // namespace

Images::Images() {
    size_t size = 0;
    for (size_t level = 0; level <= kStages; level++) {
        start_[level] = size;
        size += (level_size(level) + 15) / 16 * 16;
    }
    memory_.resize(size);
}

void put_inside(const float *image, size_t rows, size_t cols, size_t channels, float *bordered) noexcept {
    for (size_t r = 0; r < rows; r++)
        std::copy_n(image + r * cols * channels, cols * channels, bordered + ((r + 1) * (cols + 2) + 1) * channels);
}

void get_inside(const float *bordered, size_t rows, size_t cols, size_t channels, float *image) noexcept {
    for (size_t r = 0; r < rows; r++)
        std::copy_n(bordered + ((r + 1) * (cols + 2) + 1) * channels, cols * channels, image + r * cols * channels);
}

struct Network::Workspace {
    Buffer<double> residual = Buffer<double>(kPixels);
    Images images;
};

Network::Network(Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained, double cosine)
    : preprocess_(std::move(preprocess)), parameters_(std::move(parameters)), packed_(pack(parameters_)), seed_(seed),
      trained_(trained), cosine_(cosine) {}

double Network::features_to_latent(float *features) const noexcept {
    const size_t row = kDeepSide * kDeepChannels;
    double latent = static_cast<double>(parameters_[kLatentBias][0]);
    for (size_t r = 0; r < kDeepSide; r++)
        latent += dense(features + ((r + 1) * (kDeepSide + 2) + 1) * kDeepChannels,
                        parameters_[kLatentWeight] + r * row, row);
    return latent;
}

double Network::encode(ImageView<const double> frame, Workspace &workspace) const {
    preprocess_.residual(frame, workspace.residual.data());
    Images &images = workspace.images;
    for (size_t r = 0; r < kSide; r++) {
        float *row = images[0] + (r + 1) * (kSide + 2) + 1;
        for (size_t c = 0; c < kSide; c++)
            row[c] = static_cast<float>(preprocess_.input_scale * workspace.residual[r * kSide + c]);
    }
    for (size_t s = 0; s < kStages; s++) {
        const kernels::ConvShape &shape = kFlight.stages[s];
        kernels::conv_kernels().down(shape, images[s], packed_.down[s].data(), parameters_[conv_bias(s)],
                                     images[s + 1]);
        kernels::elu_kernels().elu(images[s + 1], shape.coarse());
    }
    const double latent = features_to_latent(images[kStages]);
    if (!std::isfinite(latent))
        fail(Status::range, "counts: the latent is not finite; counts are too far from the scene's");
    return latent;
}

double Network::encode(ImageView<const double> frame) const {
    Workspace workspace;
    return encode(frame, workspace);
}

void Network::encode_many(const double *counts, size_t count, unsigned workers, double *latents) const {
    // One job a worker, so that each has one workspace; a frame's latent does not depend on who computes it.
    const size_t jobs = std::min<size_t>(worker_count(workers), count);
    Buffer<double> results(count);
    run_jobs(static_cast<unsigned>(jobs), jobs, [&](size_t job) {
        Workspace workspace;
        for (size_t i = job; i < count; i += jobs)
            try {
                const double *frame = counts + i * preprocess_.rows * preprocess_.cols;
                results[i] = encode({frame, preprocess_.rows, preprocess_.cols, preprocess_.cols}, workspace);
            } catch (const Error &error) {
                fail(error.status(), "frame %zu: %s", i, error.what());
            }
    });
    std::copy(results.begin(), results.end(), latents);
}

void Network::decode(double latent, double *image) const {
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::argument, "latent_px = %g: must be in [%g, %g]", latent, -kLargestLatent, kLargestLatent);
    paint(latent, image);
}

void Network::paint(double latent, double *image) const {
    Buffer<float> features(kFeatures);
    for (size_t i = 0; i < kFeatures; i++)
        features[i] = static_cast<float>(latent) * parameters_[kExpandWeight][i] + parameters_[kExpandBias][i];
    kernels::elu_kernels().elu(features.data(), kFeatures);
    Images images;
    put_inside(features.data(), kDeepSide, kDeepSide, kDeepChannels, images[kStages]);
    for (size_t s = kStages; s-- > 0;) {
        const kernels::ConvShape &shape = kFlight.stages[s];
        kernels::conv_kernels().up(shape, images[s + 1], packed_.up[s].data(), parameters_[deconv_bias(s)], images[s]);
        if (s > 0)
            kernels::elu_kernels().elu(images[s], shape.fine());
    }
    Buffer<float> out(kPixels);
    get_inside(images[0], kSide, kSide, 1, out.data());
    if (!std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); }))
        fail(Status::range, "cae: what the decoder paints for %g px overflows: the weights are too large", latent);
    std::copy(out.begin(), out.end(), image);
}

void Network::reconstruct(ImageView<const double> frame, double *image) const {
    const double latent = encode(frame);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::range, "counts: their latent is %g px, must be in [%g, %g]; counts are too far from the scene's",
             latent, -kLargestLatent, kLargestLatent);
    paint(latent, image);
    for (size_t i = 0; i < kPixels; i++)
        image[i] = preprocess_.reference[i] + std::sqrt(preprocess_.variance[i]) * image[i];
}

} // namespace toliman::cae
