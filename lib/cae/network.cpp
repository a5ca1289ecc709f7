#include "cae/network.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "frame/estimates.hpp"

namespace toliman::cae {

namespace {

constexpr double kFar = 1e5; // standard deviations; 6e-8 of it, float32 rounding, is not small
// The crop's place on the detector.
std::optional<DetectorWindow> of_crop(const Crop &crop, const std::optional<DetectorWindow> &frame) {
    if (!frame)
        return {};
    return DetectorWindow{frame->row + static_cast<int64_t>(crop.row), frame->col + static_cast<int64_t>(crop.col)};
}

constexpr double kLargestLatent = 1e6; // px; above it float32 activations of the decoder could overflow

} // namespace

Network::Network(Preprocess preprocess, Parameters parameters, uint64_t seed, bool trained, double cosine)
    : preprocess_(std::move(preprocess)), parameters_(std::move(parameters)), encoder_(pack_encoder(parameters_)),
      decoder_(pack_decoder(parameters_)), seed_(seed), trained_(trained), cosine_(cosine) {}

// Band by band, so that the planes' rows are read once for all frames and stay in cache.
void Network::latents_of_rows(const Crop *crops, size_t count, Workspace &work, double *latents) const {
    for (size_t f = 0; f < count; f++)
        work.rows[f].start(parameters_, encoder_);
    float *bands[kTogether];
    for (size_t f = 0; f < count; f++)
        bands[f] = work.rows[f].band();
    const size_t stride = work.rows[0].band_stride();
    for (size_t r = 0; r < layout().side; r += kBand) {
        preprocess_.band(crops, count, r, work.input, bands, stride);
        for (size_t f = 0; f < count; f++)
            work.rows[f].push_band();
    }
    for (size_t f = 0; f < count; f++)
        latents[f] = work.rows[f].latent();
}

double Network::latent_of_image(const Crop &crop, Workspace &work, Pooling *pooling) const {
    Images &images = *work.images;
    for (size_t r = 0; r < layout().side; r += kBand) {
        float *const rows = images[0] + layout().input_at(r);
        preprocess_.band(&crop, 1, r, work.input, &rows, layout().input_stride());
    }
    return cae::encode(parameters_, encoder_, images, pooling);
}

void Network::latents_of(const Crop *crops, size_t count, Workspace &work, Pooling *pooling, double *latents) const {
    work.prepare(layout(), count);
    preprocess_.start(crops, count, work.input);
    if (layout().max_pool)
        latents[0] = latent_of_image(crops[0], work, pooling);
    else
        latents_of_rows(crops, count, work, latents);
    for (size_t f = 0; f < count; f++)
        if (!std::isfinite(latents[f]))
            fail(Status::range, "{counts}: the latent is not finite: the counts are too far from the reference frame");
}

// Encodes the crop without its bad pixels; crop i of those that were encoded together. False if there are too many.
// Bad pixels that are far off leave an error by rounding, for which they are replaced again.
bool Network::repair(const Crop &crop, size_t i, Workspace &work, BadPixels &bad, Preprocess::Fitted &fitted,
                     double &latent) const {
    const size_t side = layout().side;
    work.repaired.resize(layout().pixels());
    for (size_t r = 0; r < side; r++)
        std::copy_n(crop.counts.row(r), side, &work.repaired[r * side]);
    const Crop repaired = {{work.repaired.data(), side, side, side}, crop.row, crop.col};
    bool known = bad.count() > 0; // those are replaced before others are searched for
    for (double lowered = 0;; known = false) {
        const BadPixels::Found found =
            known ? BadPixels::Found::some : preprocess_.add_bad_pixels(i, fitted, work.input, bad);
        const bool again = found == BadPixels::Found::none;
        if (again && lowered < kFar) // also if there are none
            return true;
        const double before = lowered;
        if (found == BadPixels::Found::too_many ||
            !preprocess_.lower(i, fitted, work.input, bad, work.repaired.data(), lowered) ||
            (again && !(lowered < 0.5 * before)))
            return false;
        latents_of(&repaired, 1, work, nullptr, &latent);
        i = 0;
        fitted = preprocess_.fit(repaired, i, true, work.input);
    }
}

void Network::encode(const ImageView<const double> *frames, size_t count, Workspace &work, double *latents,
                     FrameGoodness *goodness, const std::optional<DetectorWindow> *windows) const {
    Crop crops[kTogether] = {};
    std::transform(frames, frames + count, crops, [this](const auto &frame) { return preprocess_.crop_of(frame); });
    latents_of(crops, count, work, nullptr, latents);
    bool far[kTogether];
    for (size_t f = 0; f < count; f++)
        far[f] = preprocess_.may_have_bad_pixels(f, work.input);
    for (size_t f = 0; f < count; f++) { // a repair overwrites the working memory of frame 0
        BadPixels bad;
        const bool few_known = windows == nullptr || preprocess_.known_bad.add(of_crop(crops[f], windows[f]), bad),
                   known = bad.count() > 0;
        if (!far[f] && goodness == nullptr && !known)
            continue;
        Preprocess::Fitted fitted = preprocess_.fit(crops[f], f, far[f] || known, work.input), without = fitted;
        double latent;
        const bool may_be_bad = known || (far[f] && static_cast<double>(fitted.excess) > kBadPixelLimit),
                   few_bad = few_known && (!may_be_bad || repair(crops[f], f, work, bad, without, latent));
        const bool repaired = may_be_bad && few_bad && bad.count() > 0;
        if (repaired) {
            fitted = without;
            latents[f] = latent;
        }
        if (goodness != nullptr)
            goodness[f] = preprocess_.goodness(fitted, repaired ? bad.count() : 0, few_bad);
    }
}

double Network::encode(ImageView<const double> frame, Workspace &work, FrameGoodness *goodness,
                       const std::optional<DetectorWindow> &window) const {
    double latent;
    encode(&frame, 1, work, &latent, goodness, &window);
    return latent;
}

uint64_t Network::digest() const noexcept {
    return fnv1a(parameters_.values, fnv1a(layout_hash(layout()), preprocess_.digest()));
}

void Network::encode_many(const PixelFrames &frames, size_t count, unsigned workers, double *latents,
                          FrameGoodness *goodness) const {
    const size_t together = layout().max_pool ? 1 : kTogether;
    estimate_many(
        frames, count, together, workers, latents, goodness, [] { return Workspace(); },
        [this, &frames](const ImageView<const double> *group, size_t first, size_t size, Workspace &work,
                        double *values, FrameGoodness *of_group) {
            std::optional<DetectorWindow> windows[kTogether];
            for (size_t i = 0; i < size; i++)
                windows[i] = frames.window(first + i);
            encode(group, size, work, values, of_group, windows);
        });
}

void Network::decode(double latent, double *image) const {
    if (layout().max_pool)
        fail(Status::unsupported,
             "cae: layout = %s: decode requires layout %s or %s: use reconstruct, which has the switches",
             layout().name, kFlight.name, kCore.name);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::argument, "{latent_px} = %g: must be in [%g, %g]", latent, -kLargestLatent, kLargestLatent);
    Pooling pooling(layout());
    run_decoder(latent, pooling, image);
}

void Network::run_decoder(double latent, Pooling &pooling, double *image) const {
    Images images(layout());
    cae::decode(parameters_, decoder_, static_cast<float>(latent), images, pooling);
    Buffer<float> out(layout().pixels());
    get_inside(images[0], layout().side, layout().side, 1, out.data());
    if (!std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); }))
        fail(Status::range, "cae: the decoder output for latent = %g px overflows: the weights are too large", latent);
    std::copy(out.begin(), out.end(), image);
}

void Network::reconstruct(ImageView<const double> frame, double *image) const {
    Workspace work;
    Pooling pooling(layout());
    double latent;
    const Crop crop = preprocess_.crop_of(frame);
    latents_of(&crop, 1, work, &pooling, &latent);
    if (!(std::fabs(latent) <= kLargestLatent))
        fail(Status::range,
             "{counts}: latent = %g px: must be in [%g, %g]: the counts are too far from the reference frame", latent,
             -kLargestLatent, kLargestLatent);
    run_decoder(latent, pooling, image);
    preprocess_.to_counts(image);
}

} // namespace toliman::cae
