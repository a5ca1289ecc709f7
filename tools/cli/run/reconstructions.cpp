#include "run/reconstructions.hpp"

#include <algorithm>
#include <cmath>

#include "common/library.hpp"
#include "common/parallel.hpp"

namespace cli {

namespace {

constexpr size_t kValidationFrames = 110; // size of the book chapter's validation set

using toliman::check;

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

} // namespace cli
