#include "experiment/reconstructions.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "common/library.hpp"

namespace cli {

namespace {

constexpr size_t kValidationFrames = 110; // size of the book chapter's validation set
constexpr size_t kPixels = kNetworkSide * kNetworkSide;

using toliman::check;

void append(std::vector<double> &images, const std::vector<double> &image) {
    images.insert(images.end(), image.begin(), image.end());
}

} // namespace

Reconstructor::Reconstructor(const Scene &scene, const toliman::autoencoder &cae, uint64_t seed, size_t total)
    : scene_(scene), cae_(cae) {
    const auto info = info_from<toliman_cae_info>(toliman_cae_get_info, cae.get());
    result_.crop_row = static_cast<size_t>(info.crop_row);
    result_.crop_col = static_cast<size_t>(info.crop_col);
    sigma_ = cropped(scene.image(TOLIMAN_SIM_IMAGE_VARIANCE).data());
    for (double &pixel : sigma_)
        pixel = std::sqrt(pixel);
    result_.validation_frames = std::min(total, kValidationFrames);
    std::mt19937_64 random(seed);
    for (size_t i = 0; i < kSamples; i++) {
        const size_t first = i * total / kSamples, width = (i + 1) * total / kSamples - first;
        result_.samples.push_back(first + static_cast<size_t>(random() % width));
    }
}

// The part of a frame that the network sees.
Reconstructor::Image Reconstructor::cropped(const double *image) const {
    const auto cols = static_cast<size_t>(scene_.info.cols);
    Image part;
    part.reserve(kPixels);
    for (size_t row = 0; row < kNetworkSide; row++) {
        const double *start = image + (result_.crop_row + row) * cols + result_.crop_col;
        part.insert(part.end(), start, start + kNetworkSide);
    }
    return part;
}

void Reconstructor::add_residual(const Image &residual) {
    double sum = 0, square = 0, product = 0;
    for (size_t i = 0; i < kPixels; i++) {
        sum += residual[i];
        square += residual[i] * residual[i];
        product += (i + 1) % kNetworkSide != 0 ? residual[i] * residual[i + 1] : 0;
    }
    const auto frames = static_cast<double>(result_.validation_frames);
    result_.residual_mean += sum / (kPixels * frames);
    result_.residual_square += square / (kPixels * frames);
    result_.residual_product += product / ((kPixels - kNetworkSide) * frames);
}

void Reconstructor::take(size_t k, const double *image) {
    const bool is_sample = std::binary_search(result_.samples.begin(), result_.samples.end(), k);
    if (k >= result_.validation_frames && !is_sample)
        return;
    Image reconstruction(kPixels), residual(kPixels);
    double mmse, mssim, floor;
    check(toliman_cae_reconstruct(cae_.get(), image, static_cast<size_t>(scene_.info.cols), reconstruction.data(),
                                  kNetworkSide, &mmse, &mssim, &floor));
    const Image frame = cropped(image);
    for (size_t i = 0; i < kPixels; i++)
        residual[i] = (frame[i] - reconstruction[i]) / sigma_[i];
    if (k < result_.validation_frames) {
        const auto share = 1 / static_cast<double>(result_.validation_frames);
        result_.mmse += mmse * share;
        result_.mssim += mssim * share;
        result_.photon_floor += floor * share;
        add_residual(residual);
    }
    if (is_sample) {
        append(result_.frames, frame);
        append(result_.reconstructions, reconstruction);
        append(result_.residuals, residual);
    }
}

} // namespace cli
