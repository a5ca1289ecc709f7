// Method: all methods have one interface: push frames, then get the series of values. Networks and the template encode
// each frame on arrival. Methods that learn from the series (series_methods) keep the frames and are fitted when the
// series is complete. A method is one class and one row of method_kinds().
#include "experiment/methods.hpp"

#include <functional>
#include <utility>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/text.hpp"
#include "experiment/series_methods.hpp"
#include "options/suggest.hpp"

namespace cli {

namespace {

using toliman::check;

// Methods that need no series: each frame is encoded on arrival.
class FrameByFrame : public Method {
  public:
    using Encode = std::function<toliman_status(const toliman_image *image, size_t count, double *values)>;
    explicit FrameByFrame(Encode encode) : encode_(std::move(encode)) {}

    void push(const double *images, size_t count) override {
        const toliman_image image = plain_image(images);
        values_.resize(values_.size() + count);
        check(encode_(&image, count, &values_[values_.size() - count]));
    }

    std::vector<double> series() override { return std::exchange(values_, {}); }

  private:
    Encode encode_;
    std::vector<double> values_;
};

std::unique_ptr<Method> make_template(const Scene &scene, uint64_t) {
    const std::shared_ptr<toliman_linear> linear =
        toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr);
    return std::make_unique<FrameByFrame>([linear](const toliman_image *image, size_t count, double *values) {
        return toliman_linear_encode_many(linear.get(), image, count, 0, values, nullptr);
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
        return toliman_cae_encode_many(cae.get(), image, count, 0, values, nullptr);
    });
}

template <Component which> std::unique_ptr<Method> make_component(const Scene &scene, uint64_t seed) {
    return make_component(scene, which, seed);
}

} // namespace

const std::vector<MethodKind> &method_kinds() {
    static const std::vector<MethodKind> kinds = {
        {"cae", "the autoencoder, trained once for each seed of weights, without frames", true, false, false,
         [](const Scene &scene, uint64_t seed) { return make_network(scene, seed, nullptr, true); }},
        {"template", "least squares on the scene's derivative image: the reference method", true, false, false,
         make_template},
        {"untrained", "the autoencoder with random weights: shows what is found without training", true, false, false,
         [](const Scene &scene, uint64_t seed) { return make_network(scene, seed, nullptr, false); }},
        {"pca", "first principal component of the series' own frames, in counts", false, true, false,
         make_component<Component::raw>},
        {"pca-white", "the same for residuals divided by their sigma", false, true, false,
         make_component<Component::whitened>},
        {"pca-blocks", "the same for means over 1/27 of the series each, one value per mean", false, true, false,
         make_component<Component::blocks>},
        {"dictionary", "one sparse dictionary atom (lambda 1) of residuals divided by their sigma", false, true, false,
         make_component<Component::dictionary>},
        {"untrained-paper", "the book chapter's network and input (maximum pooling, counts), random weights", false,
         false, false,
         [](const Scene &scene, uint64_t seed) {
             const toliman_cae_options options = chapter_network();
             return make_network(scene, seed, &options, false);
         }},
        {"cae-unsupervised", "the same trained on the series' own frames for 10 epochs, without a prior", false, true,
         true, make_unsupervised},
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
