// Method: all methods have one interface: push frames, then get the series of values. Networks and the template encode
// each frame on arrival. Methods that learn from the series (series_methods) keep the frames and are fitted when the
// series is complete. A method is one class and one row of method_kinds().
#include "experiment/methods.hpp"

#include <utility>

#include "common/failure.hpp"
#include "experiment/series_methods.hpp"
#include "frames/network.hpp"
#include "options/suggest.hpp"

namespace cli {

namespace {

using toliman::check;

// Methods that need no series: each frame is encoded on arrival.
class FrameByFrame : public Method {
  public:
    void push(const double *images, size_t count) override {
        values_.resize(values_.size() + count);
        encode(images, count, &values_[values_.size() - count]);
    }

    std::vector<double> series() override { return std::exchange(values_, {}); }

  protected:
    virtual void encode(const double *images, size_t count, double *values) const = 0;

  private:
    std::vector<double> values_;
};

class TemplateMethod : public FrameByFrame {
  public:
    explicit TemplateMethod(const Scene &scene)
        : linear_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr)) {}

  private:
    void encode(const double *images, size_t count, double *values) const override {
        const toliman_image image = plain_image(images);
        check(toliman_linear_encode_many(linear_.get(), &image, count, 0, values, nullptr));
    }

    toliman::linear_estimator linear_;
};

class NetworkMethod : public FrameByFrame {
  public:
    NetworkMethod(const Scene &scene, uint64_t seed, const toliman_cae_options *options)
        : cae_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, options)) {}

    void train() {
        toliman_cae_train_options options;
        toliman_cae_train_options_init(&options, sizeof options);
        options.progress = stop_asked;
        check(toliman_cae_train(cae_.get(), &options, nullptr));
    }

  private:
    void encode(const double *images, size_t count, double *values) const override {
        const toliman_image image = plain_image(images);
        check(toliman_cae_encode_many(cae_.get(), &image, count, 0, values, nullptr));
    }

    toliman::autoencoder cae_;
};

} // namespace

const std::vector<MethodKind> &method_kinds() {
    static const std::vector<MethodKind> kinds = {
        {"cae", "the autoencoder, trained once for each seed of weights, without frames", true, false, false,
         [](const Scene &scene, uint64_t seed) -> std::unique_ptr<Method> {
             auto method = std::make_unique<NetworkMethod>(scene, seed, nullptr);
             method->train();
             return method;
         }},
        {"template", "least squares on the scene's derivative image: the reference method", true, false, false,
         [](const Scene &scene, uint64_t) -> std::unique_ptr<Method> {
             return std::make_unique<TemplateMethod>(scene);
         }},
        {"untrained", "the autoencoder with random weights: shows what is found without training", true, false, false,
         [](const Scene &scene, uint64_t seed) -> std::unique_ptr<Method> {
             return std::make_unique<NetworkMethod>(scene, seed, nullptr);
         }},
        {"pca", "first principal component of the series' own frames, in counts", false, true, false,
         [](const Scene &scene, uint64_t seed) { return make_component(scene, Component::raw, seed); }},
        {"pca-white", "the same for residuals divided by their sigma", false, true, false,
         [](const Scene &scene, uint64_t seed) { return make_component(scene, Component::whitened, seed); }},
        {"pca-blocks", "the same for means over 1/27 of the series each, one value per mean", false, true, false,
         [](const Scene &scene, uint64_t seed) { return make_component(scene, Component::blocks, seed); }},
        {"dictionary", "one sparse dictionary atom (lambda 1) of residuals divided by their sigma", false, true, false,
         [](const Scene &scene, uint64_t seed) { return make_component(scene, Component::dictionary, seed); }},
        {"untrained-paper", "the book chapter's network and input (maximum pooling, counts), random weights", false,
         false, false,
         [](const Scene &scene, uint64_t seed) -> std::unique_ptr<Method> {
             const toliman_cae_options options = chapter_network();
             return std::make_unique<NetworkMethod>(scene, seed, &options);
         }},
        {"cae-unsupervised", "the same trained on the series' own frames for 10 epochs, without a prior", false, true,
         true, make_unsupervised},
    };
    return kinds;
}

const MethodKind &method_kind(const std::string &name) {
    std::vector<std::string> names;
    std::string known;
    for (const MethodKind &kind : method_kinds()) {
        if (kind.name == name)
            return kind;
        names.emplace_back(kind.name);
        known += (known.empty() ? "" : ", ") + names.back();
    }
    throw Failure(kExitUsage, "--methods " + name + ": must be one of " + known + did_you_mean(name, names));
}

} // namespace cli
