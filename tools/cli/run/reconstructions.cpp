#include "run/reconstructions.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "common/library.hpp"
#include "common/parallel.hpp"

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
    const auto info = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae.get(), nullptr);
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

bool Reconstructor::is_sample(size_t k) const {
    return std::binary_search(result_.samples.begin(), result_.samples.end(), k);
}

void Reconstructor::take(size_t first, const double *images, size_t count) {
    std::vector<Reconstruction> all;
    for (size_t k = first; k < first + count; k++)
        if (k < result_.validation_frames || is_sample(k))
            all.emplace_back().k = k;
    run_parallel(all.size(), [&](size_t i) { reconstruct(images + (all[i].k - first) * scene_.pixels(), all[i]); });
    for (const Reconstruction &one : all) // in order, so that the sums have the same bits for any number of threads
        add(one);
}

void Reconstructor::reconstruct(const double *image, Reconstruction &result) const {
    result.image.resize(kPixels);
    result.residual.resize(kPixels);
    check(toliman_cae_reconstruct(cae_.get(), image, static_cast<size_t>(scene_.info.cols), result.image.data(),
                                  kNetworkSide, &result.mmse, &result.mssim, &result.photon_floor));
    result.frame = cropped(image);
    for (size_t i = 0; i < kPixels; i++)
        result.residual[i] = (result.frame[i] - result.image[i]) / sigma_[i];
}

void Reconstructor::add(const Reconstruction &one) {
    if (one.k < result_.validation_frames) {
        const auto share = 1 / static_cast<double>(result_.validation_frames);
        result_.mmse += one.mmse * share;
        result_.mssim += one.mssim * share;
        result_.photon_floor += one.photon_floor * share;
        add_residual(one.residual);
    }
    if (is_sample(one.k)) {
        append(result_.frames, one.frame);
        append(result_.reconstructions, one.image);
        append(result_.residuals, one.residual);
    }
}

} // namespace cli
