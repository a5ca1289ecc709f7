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

void scale(const double *from, size_t count, double factor, float *to) noexcept {
    std::transform(from, from + count, to, [factor](double value) { return static_cast<float>(factor * value); });
}

} // namespace

EncoderWork::EncoderWork(const Layout &layout) {
    if (layout.max_pool)
        images_.emplace(layout);
    else
        rows_.emplace(layout);
}

Encoder::Encoder(Parameters weights) : weights_(std::move(weights)), packed_(pack_encoder(weights_)) {
    const Buffer<double> gradient = gradient_of(weights_);
    gradient_.assign(gradient.begin(), gradient.end());
}

double Encoder::latent(const double *image, EncoderWork &work) const noexcept {
    if (layout().max_pool)
        return (latent_of_maxima(image, kScale, *work.images_) - latent_of_maxima(image, -kScale, *work.images_)) /
               (2 * kScale);
    EncoderRows &rows = *work.rows_;
    const size_t side = layout().side;
    rows.start(weights_, packed_);
    for (size_t r = 0; r < side; r += kBand) {
        for (size_t i = 0; i < kBand; i++)
            scale(image + (r + i) * side, side, kScale, rows.band() + i * rows.band_stride());
        rows.push_band();
    }
    return rows.latent() / kScale;
}

double Encoder::latent_of_maxima(const double *image, double factor, Images &images) const noexcept {
    const size_t side = layout().side;
    for (size_t r = 0; r < side; r++)
        scale(image + r * side, side, factor, images[0] + layout().input_at(r));
    return encode(weights_, packed_, images, nullptr);
}

Response Encoder::response() const {
    if (!layout().max_pool)
        return {};
    double norm = 0;
    for (const float value : gradient_)
        norm += static_cast<double>(value) * static_cast<double>(value);
    norm = std::sqrt(norm);
    EncoderWork work(layout());
    const size_t pixels = layout().pixels();
    Buffer<double> noise(pixels), image(pixels);
    double squares = 0, slope = 0;
    for (int draw = 0; draw < kDraws; draw++) {
        kernels::Rng rng(static_cast<uint64_t>(draw), kernels::kStreamResponse);
        std::generate(noise.begin(), noise.end(), [&] { return rng.normal(); });
        const double latent_of_noise = latent(noise.data(), work);
        squares += latent_of_noise * latent_of_noise;
        for (const double sign : {-1.0, 1.0}) {
            for (size_t i = 0; i < pixels; i++)
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
