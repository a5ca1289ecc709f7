#include "cae/network.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/estimates.hpp"
#include "base/hash.hpp"

namespace toliman::cae {

namespace {

constexpr double kLargestLatent = 1e6; // px; above it float32 activations of the decoder could overflow

} // namespace

Network::Network(const Layout &layout, Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained,
                 double cosine)
    : layout_(&layout), preprocess_(std::move(preprocess)), parameters_(std::move(parameters)),
      encoder_(pack_encoder(layout, parameters_)), decoder_(pack_decoder(layout, parameters_)), seed_(seed),
      trained_(trained), cosine_(cosine) {}

double Network::latent_of(ImageView<const double> frame, Workspace &work, Pooling *pooling) const {
    preprocess_.apply(frame, work.scratch, work.images[0] + kInputStride + 1, kInputStride);
    const double latent = cae::encode(*layout_, parameters_, encoder_, work.images, pooling);
    if (!std::isfinite(latent))
        fail(Status::range, "{counts}: the latent is not finite: the counts are too far from the reference frame");
    return latent;
}

double Network::encode(ImageView<const double> frame, Workspace &work, double *chi_square) const {
    const double latent = latent_of(frame, work, nullptr);
    if (chi_square != nullptr)
        *chi_square = preprocess_.chi_square(frame, work.scratch);
    return latent;
}

uint64_t Network::digest() const noexcept {
    return fnv1a(parameters_.values, fnv1a(layout_hash(*layout_), preprocess_.digest()));
}

void Network::encode_many(const PixelFrames &frames, size_t count, unsigned workers, double *latents,
                          double *chi_square) const {
    estimate_many<Workspace>(
        frames, count, workers, latents, chi_square,
        [this](ImageView<const double> frame, Workspace &work, double *square) { return encode(frame, work, square); });
}

void Network::decode(double latent, double *image) const {
    if (layout_->max_pool)
        fail(Status::unsupported,
             "cae: layout = %s: decode requires layout %s: use reconstruct, which has the switches", layout_->name,
             kFlight.name);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::argument, "{latent_px} = %g: must be in [%g, %g]", latent, -kLargestLatent, kLargestLatent);
    Pooling pooling(*layout_);
    run_decoder(latent, pooling, image);
}

void Network::run_decoder(double latent, Pooling &pooling, double *image) const {
    Images images;
    cae::decode(*layout_, parameters_, decoder_, static_cast<float>(latent), images, pooling);
    Buffer<float> out(kPixels);
    get_inside(images[0], kSide, kSide, 1, out.data());
    if (!std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); }))
        fail(Status::range, "cae: the decoder output for latent = %g px overflows: the weights are too large", latent);
    std::copy(out.begin(), out.end(), image);
}

void Network::reconstruct(ImageView<const double> frame, double *image) const {
    Workspace work;
    Pooling pooling(*layout_);
    const double latent = latent_of(frame, work, &pooling);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::range,
             "{counts}: latent = %g px: must be in [%g, %g]: the counts are too far from the reference frame", latent,
             -kLargestLatent, kLargestLatent);
    run_decoder(latent, pooling, image);
    preprocess_.to_counts(image);
}

} // namespace toliman::cae
