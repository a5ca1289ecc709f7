// Method: all methods have one interface: push frames, then get the series of values. Networks, the template and the
// fit encode each frame on arrival. Components are fitted to the whole series after its last frame (principal
// components, sparse dictionary); a value is the frame's coefficient, with arbitrary sign and unit. For B block means
// of N frames the noise of a sample is sigma sqrt(B/N), so that by the threshold in theory.hpp the smallest signal that
// is the first component is proportional to B^(1/4): B is as small as a few periods of the signal allow. The
// unsupervised network keeps the frames as float32, the precision of its input. A method is one class and one row of
// method_kinds().
#include "experiment/methods.hpp"

#include <algorithm>
#include <functional>
#include <mutex>
#include <utility>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "experiment/fit_method.hpp"
#include "options/suggest.hpp"

namespace cli {

namespace {

using toliman::check;

// Progress callback that cancels a training after a signal.
int32_t stop_asked(const char *, double, void *) noexcept {
    return stop_signal() != 0;
}

// Methods that need no series: each frame is encoded on arrival.
class FrameByFrame : public Method {
  public:
    using Encode = std::function<toliman_status(const toliman_image *image, size_t count, double *values)>;
    explicit FrameByFrame(Encode encode) : encode_(std::move(encode)) {}

    void push(const double *images, const double *, size_t count) override {
        const toliman_image image = plain_image(images);
        values_.resize(values_.size() + count);
        check(encode_(&image, count, &values_[values_.size() - count]));
    }

    std::vector<double> series() override { return std::exchange(values_, {}); }

  private:
    Encode encode_;
    std::vector<double> values_;
};

std::unique_ptr<Method> make_template(const Scene &scene, uint64_t, SharedFrames &) {
    const std::shared_ptr<toliman_linear> linear =
        toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr);
    return std::make_unique<FrameByFrame>([linear](const toliman_image *image, size_t count, double *values) {
        return toliman_linear_encode(linear.get(), image, count, values, nullptr);
    });
}

std::unique_ptr<Method> make_network(const Scene &scene, uint64_t seed, const toliman_cae_options *options,
                                     bool trained) {
    const std::shared_ptr<toliman_cae> cae =
        toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, options);
    auto training = toliman::sized<toliman_cae_train_options>();
    training.progress = stop_asked;
    if (trained)
        check(toliman_cae_train(cae.get(), &training, nullptr));
    return std::make_unique<FrameByFrame>([cae](const toliman_image *image, size_t count, double *values) {
        return toliman_cae_encode(cae.get(), image, count, values, nullptr);
    });
}

// B, the number of block means (or a few more, as blocks have floor(N/B) frames): it still samples a few periods.
constexpr size_t kBlocks = 27;

// What the leading component of the frames is computed from: counts, whitened residuals, or block means of these.
enum class Component { raw, whitened, blocks };

} // namespace

// The frames of a component method, or of several that push the same ones: the first push of a frame adds it, and the
// first training computes the products of frames.
class ComponentFrames {
  public:
    ComponentFrames(const Scene &scene, Component which) : scene_(scene), pixels_(scene.pixels()) {
        const auto frames = static_cast<size_t>(scene.info.frames);
        if (which == Component::blocks)
            block_ = std::max<size_t>(1, frames / kBlocks);
        options_.raw = which == Component::raw ? 1 : 0;
        options_.capacity = static_cast<uint32_t>(frames / block_);
        begin();
    }

    size_t block() const noexcept { return block_; }

    // Frames first ... first + count - 1 of a series; frame 0 forgets the last series once its values were taken.
    void push(size_t first, const double *images, size_t count) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (first == 0 && taken_)
            begin();
        for (size_t k = added_ - std::min(added_, first); k < count; k++)
            add(images + k * pixels_);
    }

    std::vector<double> series(const toliman_components_train_options &training) {
        const std::lock_guard<std::mutex> lock(mutex_);
        check(toliman_components_train(components_.get(), &training, nullptr));
        std::vector<double> values(pushed_);
        check(toliman_components_get_series(components_.get(), 0, values.data(), nullptr));
        taken_ = true;
        return values;
    }

  private:
    void begin() {
        components_.reset(); // its memory first
        components_ = toliman::make<toliman::component_set>(toliman_components_create, scene_.sim.get(), &options_);
        added_ = pushed_ = 0;
        taken_ = false;
    }

    void add(const double *image) {
        if (added_++ % block_ == 0)
            mean_.assign(pixels_, 0);
        for (size_t i = 0; i < pixels_; i++)
            mean_[i] += image[i] / static_cast<double>(block_);
        if (added_ % block_ != 0)
            return;
        const toliman_image whole = plain_image(mean_.data());
        check(toliman_components_push(components_.get(), &whole, 1));
        pushed_++;
    }

    const Scene &scene_;
    toliman_components_options options_ = toliman::sized<toliman_components_options>();
    std::mutex mutex_;
    size_t pixels_, block_ = 1, added_ = 0, pushed_ = 0; // frames, and means of blocks of them
    bool taken_ = false;
    std::vector<double> mean_;
    toliman::component_set components_;
};

namespace {

class ComponentMethod : public Method {
  public:
    ComponentMethod(std::shared_ptr<ComponentFrames> frames, int32_t method, uint64_t seed)
        : frames_(std::move(frames)) {
        training_ = toliman::sized<toliman_components_train_options>();
        training_.method = method;
        training_.seed = seed;
        training_.progress = stop_asked;
    }

    size_t block() const noexcept override { return frames_->block(); }

    void push(const double *images, const double *, size_t count) override {
        frames_->push(pushed_, images, count);
        pushed_ += count;
    }

    std::vector<double> series() override {
        pushed_ = 0;
        return frames_->series(training_);
    }

  private:
    std::shared_ptr<ComponentFrames> frames_;
    size_t pushed_ = 0;
    toliman_components_train_options training_ = {};
};

// The book chapter's network: its layout and input, trained by the mean squared error of the reconstruction.
toliman_cae_options chapter_network() {
    auto options = toliman::sized<toliman_cae_options>();
    options.layout = TOLIMAN_CAE_LAYOUT_PAPER;
    options.input = TOLIMAN_CAE_INPUT_RAW;
    return options;
}
constexpr uint32_t kChapterEpochs = 10;

class UnsupervisedMethod : public Method {
  public:
    UnsupervisedMethod(const Scene &scene, uint64_t seed) : scene_(scene), seed_(seed) {
        frames_.reserve(static_cast<size_t>(scene.info.frames) * scene.pixels());
    }

    void push(const double *images, const double *, size_t count) override {
        frames_.insert(frames_.end(), images, images + count * scene_.pixels());
    }

    std::vector<double> series() override {
        const toliman_cae_options network = chapter_network();
        const auto cae = toliman::make<toliman::autoencoder>(toliman_cae_create, scene_.sim.get(), seed_, &network);
        auto options = toliman::sized<toliman_cae_train_options>();
        options.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
        options.steps = kChapterEpochs;
        options.frames = give;
        options.frames_data = this;
        options.frame_count = frames_.size() / scene_.pixels();
        options.progress = stop_asked;
        check(toliman_cae_train(cae.get(), &options, nullptr));
        std::vector<double> values(options.frame_count);
        toliman_image images = plain_image(frames_.data());
        images.pixel = TOLIMAN_PIXEL_F32;
        check(toliman_cae_encode(cae.get(), &images, values.size(), values.data(), nullptr));
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

template <Component which> std::unique_ptr<Method> make_component(const Scene &scene, uint64_t seed, SharedFrames &) {
    return std::make_unique<ComponentMethod>(std::make_shared<ComponentFrames>(scene, which), TOLIMAN_COMPONENTS_PCA,
                                             seed);
}

template <int32_t method>
std::unique_ptr<Method> make_whitened(const Scene &scene, uint64_t seed, SharedFrames &shared) {
    if (!shared.whitened)
        shared.whitened = std::make_shared<ComponentFrames>(scene, Component::whitened);
    return std::make_unique<ComponentMethod>(shared.whitened, method, seed);
}

} // namespace

const std::vector<MethodKind> &method_kinds() {
    static const std::vector<MethodKind> kinds = {
        {"cae", "the autoencoder, trained once for each seed of weights, without frames", true, false, false,
         [](const Scene &scene, uint64_t seed, SharedFrames &) { return make_network(scene, seed, nullptr, true); }},
        {"template", "least squares on the scene's derivative image: the reference method", true, false, false,
         make_template},
        {"fit", "the forward model fitted to each frame: places, fluxes and background; follows moving stars", true,
         false, false,
         [](const Scene &scene, uint64_t, SharedFrames &) -> std::unique_ptr<Method> {
             return std::make_unique<FitMethod>(scene);
         }},
        {"untrained", "the autoencoder with random weights: shows what is found without training", true, false, false,
         [](const Scene &scene, uint64_t seed, SharedFrames &) { return make_network(scene, seed, nullptr, false); }},
        {"bank", "networks trained for the dates and sub-pixel places of the frames; each takes the residual of a fit",
         true, false, false,
         [](const Scene &scene, uint64_t seed, SharedFrames &) -> std::unique_ptr<Method> {
             auto bank = std::make_unique<BankMethod>(scene, seed);
             bank->train(stop_asked, nullptr);
             return bank;
         },
         true},
        {"untrained-bank", "the same with random weights", true, false, false,
         [](const Scene &scene, uint64_t seed, SharedFrames &) -> std::unique_ptr<Method> {
             return std::make_unique<BankMethod>(scene, seed);
         },
         true},
        {"pca", "first principal component of the series' own frames, in counts", false, true, false,
         make_component<Component::raw>},
        {"pca-white", "the same for residuals divided by their sigma", false, true, false,
         make_whitened<TOLIMAN_COMPONENTS_PCA>},
        {"pca-blocks", "the same for means over 1/27 of the series each, one value per mean", false, true, false,
         make_component<Component::blocks>},
        {"dictionary", "one sparse dictionary atom (lambda 1) of residuals divided by their sigma", false, true, false,
         make_whitened<TOLIMAN_COMPONENTS_DICTIONARY>},
        {"untrained-paper", "the book chapter's network and input (maximum pooling, counts), random weights", false,
         false, false,
         [](const Scene &scene, uint64_t seed, SharedFrames &) {
             const toliman_cae_options options = chapter_network();
             return make_network(scene, seed, &options, false);
         }},
        {"cae-unsupervised", "the same trained on the series' own frames for 10 epochs, without a prior", false, true,
         true,
         [](const Scene &scene, uint64_t seed, SharedFrames &) -> std::unique_ptr<Method> {
             return std::make_unique<UnsupervisedMethod>(scene, seed);
         }},
    };
    return kinds;
}

const MethodKind &method_kind(const std::string &name) {
    std::vector<std::string> names;
    for (const MethodKind &kind : method_kinds()) {
        if (kind.name == name)
            return kind;
        names.emplace_back(kind.name);
    }
    throw Failure(kExitUsage, "--methods " + name + ": must be one of " + joined(names) + did_you_mean(name, names));
}

} // namespace cli
