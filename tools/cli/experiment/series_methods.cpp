// Method: components are fitted to the whole series after its last frame (principal components, sparse dictionary); a
// value is the frame's coefficient, with arbitrary sign and unit. For B block means of N frames the noise of a sample
// is sigma sqrt(B/N), so that by the threshold in theory.hpp the smallest signal that is the first component is
// proportional to B^(1/4): B is as small as a few periods of the signal allow. The unsupervised network keeps the
// frames as float32, the precision of its input.
#include "experiment/series_methods.hpp"

#include <algorithm>
#include <utility>

namespace cli {

namespace {

using toliman::check;

// B, the number of block means (or a few more, as blocks have floor(N/B) frames): it still samples a few periods.
constexpr size_t kBlocks = 27;

class ComponentMethod : public Method {
  public:
    ComponentMethod(const Scene &scene, Component which, uint64_t seed)
        : cols_(static_cast<size_t>(scene.info.cols)), pixels_(scene.pixels()) {
        const auto frames = static_cast<size_t>(scene.info.frames);
        if (which == Component::blocks)
            block_ = std::max<size_t>(1, frames / kBlocks);
        auto options = toliman::sized<toliman_components_options>();
        options.raw = which == Component::raw ? 1 : 0;
        options.capacity = static_cast<uint32_t>(frames / block_);
        components_ = toliman::make<toliman::component_set>(toliman_components_create, scene.sim.get(), &options);
        toliman_components_train_options_init(&training_, sizeof training_);
        training_.method = which == Component::dictionary ? TOLIMAN_COMPONENTS_DICTIONARY : TOLIMAN_COMPONENTS_PCA;
        training_.seed = seed;
        training_.progress = stop_asked;
    }

    size_t block() const noexcept override { return block_; }

    void push(const double *images, size_t count) override {
        for (size_t k = 0; k < count; k++) {
            if (block_ == 1)
                push_frame(images + k * pixels_);
            else
                add(images + k * pixels_);
        }
    }

    std::vector<double> series() override {
        check(toliman_components_train(components_.get(), &training_, nullptr));
        std::vector<double> values(pushed_);
        check(toliman_components_get_series(components_.get(), 0, values.data(), nullptr));
        check(toliman_components_reset(components_.get()));
        pushed_ = summed_ = 0;
        return values;
    }

  private:
    void push_frame(const double *image) {
        check(toliman_components_push(components_.get(), image, cols_));
        pushed_++;
    }

    void add(const double *image) {
        if (summed_ == 0)
            mean_.assign(pixels_, 0);
        for (size_t i = 0; i < pixels_; i++)
            mean_[i] += image[i] / static_cast<double>(block_);
        if (++summed_ < block_)
            return;
        push_frame(mean_.data());
        summed_ = 0;
    }

    size_t cols_, pixels_, block_ = 1, pushed_ = 0, summed_ = 0; // summed_: frames in the current mean
    std::vector<double> mean_;
    toliman::component_set components_;
    toliman_components_train_options training_ = {};
};

class UnsupervisedMethod : public Method {
  public:
    UnsupervisedMethod(const Scene &scene, uint64_t seed) : scene_(scene), seed_(seed) {
        frames_.reserve(static_cast<size_t>(scene.info.frames) * scene.pixels());
    }

    void push(const double *images, size_t count) override {
        std::transform(images, images + count * scene_.pixels(), std::back_inserter(frames_),
                       [](double counts) { return static_cast<float>(counts); });
    }

    std::vector<double> series() override {
        const toliman_cae_options network = chapter_network();
        const auto cae = toliman::make<toliman::autoencoder>(toliman_cae_create, scene_.sim.get(), seed_, &network);
        auto options = toliman::sized<toliman_cae_train_options>();
        options.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
        options.epochs = kChapterEpochs;
        options.frames = give;
        options.frames_data = this;
        options.frame_count = frames_.size() / scene_.pixels();
        options.progress = stop_asked;
        check(toliman_cae_train(cae.get(), &options, nullptr));
        std::vector<double> values(options.frame_count), image(scene_.pixels());
        for (size_t i = 0; i < values.size(); i++) {
            check(give(i, 1, image.data(), this));
            check(toliman_cae_encode(cae.get(), image.data(), static_cast<size_t>(scene_.info.cols), &values[i]));
        }
        frames_.clear();
        return values;
    }

  private:
    static toliman_status give(size_t first, size_t count, double *counts, void *user_data) noexcept {
        const auto &method = *static_cast<const UnsupervisedMethod *>(user_data);
        const size_t pixels = method.scene_.pixels();
        std::copy_n(&method.frames_[first * pixels], count * pixels, counts);
        return TOLIMAN_OK;
    }

    const Scene &scene_;
    uint64_t seed_;
    std::vector<float> frames_; // relative rounding 6e-8, as of the network's input
};

} // namespace

std::unique_ptr<Method> make_component(const Scene &scene, Component which, uint64_t seed) {
    return std::make_unique<ComponentMethod>(scene, which, seed);
}

toliman_cae_options chapter_network() {
    auto options = toliman::sized<toliman_cae_options>();
    options.layout = TOLIMAN_CAE_LAYOUT_PAPER;
    options.input = TOLIMAN_CAE_INPUT_RAW;
    return options;
}

std::unique_ptr<Method> make_unsupervised(const Scene &scene, uint64_t seed) {
    return std::make_unique<UnsupervisedMethod>(scene, seed);
}

int32_t stop_asked(const char *, double, void *) noexcept {
    return stop_signal() != 0;
}

} // namespace cli
