#include "cae/network.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/workers.hpp"

namespace toliman::cae {

namespace {

constexpr double kLargestLatent = 1e6; // px; beyond it float32 could overflow on the way

} // namespace

Network::Network(const Layout &layout, Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained,
                 double cosine)
    : layout_(&layout), preprocess_(std::move(preprocess)), parameters_(std::move(parameters)),
      encoder_(pack_encoder(layout, parameters_)), decoder_(pack_decoder(layout, parameters_)), seed_(seed),
      trained_(trained), cosine_(cosine) {}

double Network::encode(ImageView<const double> frame, Workspace &work, Pooling *pooling) const {
    preprocess_.apply(frame, work.scratch, work.images[0] + kInputStride + 1, kInputStride);
    const double latent = cae::encode(*layout_, parameters_, encoder_, work.images, pooling);
    if (!std::isfinite(latent))
        fail(Status::range, "counts: the latent is not finite; counts are too far from the scene's");
    return latent;
}

double Network::encode(ImageView<const double> frame) const {
    Workspace work;
    return encode(frame, work, nullptr);
}

uint64_t Network::digest() const noexcept {
    return fnv1a(parameters_.values, fnv1a(layout_hash(*layout_), preprocess_.digest()));
}

void Network::encode_many(const double *counts, size_t count, unsigned workers, double *latents) const {
    // One job a worker, so that each has one workspace; a frame's latent does not depend on who computes it.
    const size_t jobs = std::min<size_t>(worker_count(workers), count);
    Buffer<double> results(count);
    run_jobs(static_cast<unsigned>(jobs), jobs, [&](size_t job) {
        Workspace work;
        for (size_t i = job; i < count; i += jobs)
            in_frame(i, [&] {
                const double *frame = counts + i * preprocess_.rows * preprocess_.cols;
                results[i] = encode({frame, preprocess_.rows, preprocess_.cols, preprocess_.cols}, work, nullptr);
            });
    });
    std::copy(results.begin(), results.end(), latents);
}

void Network::decode(double latent, double *image) const {
    if (layout_->max_pool)
        fail(Status::unsupported, "cae: layout %s un-pools with a frame's switches: only reconstruct can decode",
             layout_->name);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::argument, "latent_px = %g: must be in [%g, %g]", latent, -kLargestLatent, kLargestLatent);
    Pooling pooling(*layout_);
    paint(latent, pooling, image);
}

void Network::paint(double latent, Pooling &pooling, double *image) const {
    Images images;
    cae::decode(*layout_, parameters_, decoder_, static_cast<float>(latent), images, pooling);
    Buffer<float> out(kPixels);
    get_inside(images[0], kSide, kSide, 1, out.data());
    if (!std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); }))
        fail(Status::range, "cae: what the decoder paints for %g px overflows: the weights are too large", latent);
    std::copy(out.begin(), out.end(), image);
}

void Network::reconstruct(ImageView<const double> frame, double *image) const {
    Workspace work;
    Pooling pooling(*layout_);
    const double latent = encode(frame, work, &pooling);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::range, "counts: their latent is %g px, must be in [%g, %g]; counts are too far from the scene's",
             latent, -kLargestLatent, kLargestLatent);
    paint(latent, pooling, image);
    preprocess_.to_counts(image);
}

} // namespace toliman::cae
