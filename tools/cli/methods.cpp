#include "methods.hpp"

#include <utility>

#include "failure.hpp"

namespace cli {

namespace {

using toliman::check;

// Methods that know a frame when they see it: each is encoded as it comes.
class FrameByFrame : public Method {
  public:
    explicit FrameByFrame(const Scene &scene) : pixels_(scene.pixels()), cols_(static_cast<size_t>(scene.info.cols)) {}

    void push(const double *images, size_t count) override {
        values_.resize(values_.size() + count);
        encode(images, count, &values_[values_.size() - count]);
    }

    std::vector<double> series() override { return std::exchange(values_, {}); }

  protected:
    virtual void encode(const double *images, size_t count, double *values) const = 0;
    size_t pixels_, cols_;

  private:
    std::vector<double> values_;
};

class TemplateMethod : public FrameByFrame {
  public:
    explicit TemplateMethod(const Scene &scene)
        : FrameByFrame(scene),
          linear_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get())) {}

  private:
    void encode(const double *images, size_t count, double *values) const override {
        for (size_t i = 0; i < count; i++)
            check(toliman_linear_encode(linear_.get(), images + i * pixels_, cols_, &values[i]));
    }

    toliman::linear_estimator linear_;
};

class NetworkMethod : public FrameByFrame {
  public:
    NetworkMethod(const Scene &scene, uint64_t seed, bool trained)
        : FrameByFrame(scene),
          cae_(toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, nullptr)) {
        if (!trained)
            return;
        toliman_cae_train_options options;
        toliman_cae_train_options_init(&options);
        options.progress = [](const char *, double, void *) -> int32_t { return stop_signal() != 0; };
        check(toliman_cae_train(cae_.get(), &options, nullptr));
    }

  private:
    void encode(const double *images, size_t count, double *values) const override {
        check(toliman_cae_encode_many(cae_.get(), images, count, 0, values));
    }

    toliman::autoencoder cae_;
};

} // namespace

const std::vector<MethodKind> &method_kinds() {
    static const std::vector<MethodKind> kinds = {
        {"cae", "the autoencoder, trained once for each seed of weights, on the scene and no frame", false,
         [](const Scene &scene, uint64_t seed) -> std::unique_ptr<Method> {
             return std::make_unique<NetworkMethod>(scene, seed, true);
         }},
        {"template", "least squares on the scene's derivative image: the yardstick", false,
         [](const Scene &scene, uint64_t) -> std::unique_ptr<Method> {
             return std::make_unique<TemplateMethod>(scene);
         }},
        {"untrained", "the autoencoder with random weights: what it finds needs no training", false,
         [](const Scene &scene, uint64_t seed) -> std::unique_ptr<Method> {
             return std::make_unique<NetworkMethod>(scene, seed, false);
         }},
    };
    return kinds;
}

const MethodKind &method_kind(const std::string &name) {
    std::string known;
    for (const MethodKind &kind : method_kinds()) {
        if (kind.name == name)
            return kind;
        known += (known.empty() ? "" : ", ") + std::string(kind.name);
    }
    throw Failure(kExitUsage, "--methods " + name + ": unknown; there are " + known);
}

} // namespace cli
