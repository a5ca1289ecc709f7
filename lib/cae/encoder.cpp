// Method: the image is scaled by 2^-30, so that ELU(x) = x + x^2/2 + ... is linear to rounding for residuals of any
// size: a prediction of the separation that is 1000 sigma off must not bend the latent. float32 loses nothing by it.
#include "cae/encoder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cae/tied.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"

namespace toliman::cae {

namespace {

constexpr double kScale = 0x1p-30;
constexpr int kDraws = 64;           // images of noise
constexpr double kSignalSigmas = 10; // of the test image, in units of the bound; its slope is known to 1e-3

void scale(const double *from, double factor, float *to) noexcept {
    std::transform(from, from + kSide, to, [factor](double value) { return static_cast<float>(factor * value); });
}

} // namespace

EncoderWork::EncoderWork(const Layout &layout) {
    if (layout.max_pool)
        images_.emplace();
    else
        rows_.emplace();
}

Encoder::Encoder(const Layout &layout, Parameters weights)
    : layout_(&layout), weights_(std::move(weights)), packed_(pack_encoder(layout, weights_)) {
    const Buffer<double> gradient = gradient_of(weights_);
    gradient_.assign(gradient.begin(), gradient.end());
}

double Encoder::latent(const double *image, EncoderWork &work) const noexcept {
    if (layout_->max_pool)
        return (latent_of_maxima(image, kScale, *work.images_) - latent_of_maxima(image, -kScale, *work.images_)) /
               (2 * kScale);
    EncoderRows &rows = *work.rows_;
    rows.start(weights_, packed_);
    for (size_t r = 0; r < kSide; r += kBand) {
        for (size_t i = 0; i < kBand; i++)
            scale(image + (r + i) * kSide, kScale, rows.band() + i * EncoderRows::kBandStride);
        rows.push_band();
    }
    return rows.latent() / kScale;
}

double Encoder::latent_of_maxima(const double *image, double factor, Images &images) const noexcept {
    for (size_t r = 0; r < kSide; r++)
        scale(image + r * kSide, factor, images[0] + (r + 1) * kInputStride + 1);
    return encode(*layout_, weights_, packed_, images, nullptr);
}

Response Encoder::response() const {
    if (!layout_->max_pool)
        return {};
    double norm = 0;
    for (const float value : gradient_)
        norm += static_cast<double>(value) * static_cast<double>(value);
    norm = std::sqrt(norm);
    EncoderWork work(*layout_);
    Buffer<double> noise(kPixels), image(kPixels);
    double squares = 0, slope = 0;
    for (int draw = 0; draw < kDraws; draw++) {
        kernels::Rng rng(static_cast<uint64_t>(draw), kernels::kStreamResponse);
        std::generate(noise.begin(), noise.end(), [&] { return rng.normal(); });
        const double latent_of_noise = latent(noise.data(), work);
        squares += latent_of_noise * latent_of_noise;
        for (const double sign : {-1.0, 1.0}) {
            for (size_t i = 0; i < kPixels; i++)
                image[i] = noise[i] + sign * kSignalSigmas * static_cast<double>(gradient_[i]) / norm;
            slope += sign * latent(image.data(), work);
        }
    }
    Response response;
    response.gain = slope / (2 * kDraws * kSignalSigmas * norm);
    response.share = std::fmin(1, std::fabs(response.gain) * norm / std::sqrt(squares / kDraws));
    return response;
}

} // namespace toliman::cae
