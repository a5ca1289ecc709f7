#include "cae/tied.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "cae/unsupervised.hpp"
#include "kernels/adam.hpp"
#include "kernels/poisson.hpp"
#include "kernels/project.hpp"
#include "kernels/random.hpp"

namespace toliman::cae {

namespace {

constexpr float kMean = 0.25f;                          // the 2x2 mean and its adjoint
constexpr float kZeroBias[kDeepChannels] = {};          // the linear passes have none
constexpr size_t kTrained = tensor_offset(kLatentBias); // convolutions and dense weights stand first
constexpr float kLinear = 0x1p-10f; // largest activation of the decoder at 1 px: ELU bends by half of it

// Convolution kernels with orthonormal rows [coarse][9 fine], Gaussian dense weights of norm sqrt(kFeatures), no
// biases.
Parameters random_parameters(uint64_t seed) {
    kernels::Rng rng(seed, kernels::kStreamWeights);
    Parameters parameters;
    for (size_t s = 0; s < kStages; s++) {
        const size_t rows = kShapes[s].coarse_channels, cols = 9 * kShapes[s].fine_channels;
        Buffer<double> kernel(rows * cols);
        std::generate(kernel.begin(), kernel.end(), [&] { return rng.normal(); });
        kernels::orthonormalise(kernel.data(), rows, cols);
        std::transform(kernel.begin(), kernel.end(), parameters[conv_weight(s)],
                       [](double value) { return static_cast<float>(value); });
    }
    Buffer<double> dense(kFeatures);
    std::generate(dense.begin(), dense.end(), [&] { return rng.normal(); });
    const double norm = std::sqrt(kernels::dot(dense.data(), dense.data(), kFeatures) / static_cast<double>(kFeatures));
    std::transform(dense.begin(), dense.end(), parameters[kLatentWeight],
                   [norm](double value) { return static_cast<float>(value / norm); });
    return parameters;
}

// The linear decoder with the encoder's own tensors. Its image is also d latent/d input of the encoder: without biases
// every ELU stands at 0, where its slope is 1.
void paint(const Parameters &parameters, Images &images) {
    put_inside(parameters[kLatentWeight], kDeepSide, kDeepSide, kDeepChannels, images[kStages]);
    Buffer<float> packed;
    for (size_t s = kStages; s-- > 0;) {
        const kernels::ConvShape &shape = kShapes[s];
        packed.resize(shape.packed());
        kernels::conv_pack_up(shape, parameters[conv_weight(s)], kMean, packed.data());
        kernels::conv_kernels().up(shape, images[s + 1], packed.data(), kZeroBias, images[s]);
    }
}

Buffer<double> painted(Images &images) {
    Buffer<float> image(kPixels);
    get_inside(images[0], kSide, kSide, 1, image.data());
    return Buffer<double>(image.begin(), image.end());
}

// Gradient of the trained tensors from that of the painted image, which stands in backward[0].
void backward_pass(const Parameters &parameters, Images &forward, Images &backward, Parameters &gradient) {
    Buffer<float> packed;
    for (size_t s = 0; s < kStages; s++) {
        const kernels::ConvShape &shape = kShapes[s];
        packed.resize(shape.packed());
        kernels::conv_kernels().weight_gradient(shape, backward[s], forward[s + 1], packed.data());
        kernels::conv_unpack_gradient(shape, packed.data(), kMean, gradient[conv_weight(s)]);
        kernels::conv_pack_down(shape, parameters[conv_weight(s)], kMean, packed.data());
        kernels::conv_kernels().down(shape, backward[s], packed.data(), kZeroBias, backward[s + 1]);
    }
    get_inside(backward[kStages], kDeepSide, kDeepSide, kDeepChannels, gradient[kLatentWeight]);
}

double norm(const Buffer<double> &image) {
    return std::sqrt(kernels::dot(image.data(), image.data(), image.size()));
}

// Squared distance of gain times the painted image from the unit target; its gradient by the painted image.
double squared_error(const Buffer<double> &image, double gain, const Buffer<double> &unit, Buffer<float> &gradient) {
    double loss = 0;
    for (size_t i = 0; i < kPixels; i++) {
        const double error = gain * image[i] - unit[i];
        loss += error * error;
        gradient[i] = static_cast<float>(2 * gain * error);
    }
    return loss;
}

// Fits the linear decoder to the target's direction; returns the loss.
double fit(Parameters &parameters, const Buffer<double> &target, const TrainOptions &options) {
    Buffer<double> unit = target;
    const double length = norm(target);
    if (!(length > 0))
        fail(Status::state, "cae: the scene's derivative image is zero: there is nothing to train on");
    for (double &value : unit)
        value /= length;

    Images forward, backward;
    Parameters gradient, mean, square;
    Buffer<float> error(kPixels);
    paint(parameters, forward);
    Buffer<double> image = painted(forward);
    const double gain = 1 / norm(image);
    double loss = squared_error(image, gain, unit, error);
    for (uint32_t step = 1; step <= options.steps; step++) {
        const double done = static_cast<double>(step) / static_cast<double>(options.steps);
        put_inside(error.data(), kSide, kSide, 1, backward[0]);
        backward_pass(parameters, forward, backward, gradient);
        kernels::adam(step, options.learning_rate * std::min(1.0, 2 * (1.02 - done)), gradient.values.data(), kTrained,
                      mean.values.data(), square.values.data(), parameters.values.data());
        paint(parameters, forward);
        image = painted(forward);
        loss = squared_error(image, gain, unit, error);
        if (!std::isfinite(loss))
            fail(Status::range, "learning_rate = %g: training diverged at step %u", options.learning_rate, step);
        options.progress.report("train", done);
    }
    return loss;
}

void scale(float *values, size_t count, double factor) noexcept {
    for (size_t i = 0; i < count; i++)
        values[i] = static_cast<float>(values[i] * factor);
}

// 1/value, or 1 where that has no use.
double reciprocal(double value) noexcept {
    return std::isfinite(1 / value) && value != 0 ? 1 / value : 1;
}

// The decoder from the encoder: its transposed kernels, scaled so that activations stay below kLinear at 1 px and that
// what it paints at 1 px holds the target once.
void mirror(Parameters &parameters, const Buffer<double> &target) {
    Images images;
    std::copy_n(parameters[kLatentWeight], kFeatures, parameters[kExpandWeight]);
    float *tensor = parameters[kExpandWeight];
    size_t tensor_size = kFeatures;
    put_inside(tensor, kDeepSide, kDeepSide, kDeepChannels, images[kStages]);
    Buffer<float> packed;
    for (size_t s = kStages; s-- > 0;) {
        const kernels::ConvShape &shape = kShapes[s];
        float largest = 0;
        for (size_t i = 0; i < level_size(s + 1); i++)
            largest = std::max(largest, std::fabs(images[s + 1][i]));
        const double factor = kLinear * reciprocal(largest);
        scale(tensor, tensor_size, factor);
        scale(images[s + 1], level_size(s + 1), factor);

        tensor = parameters[deconv_weight(s)];
        tensor_size = kTensorTable[deconv_weight(s)].count();
        std::copy_n(parameters[conv_weight(s)], tensor_size, tensor);
        packed.resize(shape.packed());
        kernels::conv_pack_up(shape, tensor, 1.0f, packed.data());
        kernels::conv_kernels().up(shape, images[s + 1], packed.data(), kZeroBias, images[s]);
    }
    const Buffer<double> image = painted(images);
    scale(tensor, tensor_size,
          kernels::dot(target.data(), target.data(), kPixels) *
              reciprocal(kernels::dot(image.data(), target.data(), kPixels)));
}

// Scales both halves to px; returns the cosine of d latent/d residual and the target.
double scale_to_pixels(Parameters &parameters, const Preprocess &preprocess) {
    Images images;
    paint(parameters, images);
    Buffer<double> slope = painted(images);
    kernels::project_out(preprocess.units.data(), preprocess.projected, kPixels, slope.data());
    const double along = kernels::dot(slope.data(), preprocess.target.data(), kPixels);
    scale(parameters[kLatentWeight], kFeatures, reciprocal(preprocess.input_scale * along));
    mirror(parameters, preprocess.target);
    return std::min(1.0, std::fabs(along) * reciprocal(norm(slope) * norm(preprocess.target)));
}

} // namespace

Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed) {
    const bool linear = !layout.max_pool && preprocess.input == Input::whitened;
    Parameters parameters = linear ? random_parameters(seed) : initial_weights(seed);
    if (linear)
        scale_to_pixels(parameters, preprocess);
    else
        preprocess.input_scale = 1;
    return Network(layout, std::move(preprocess), std::move(parameters), seed, false, 0);
}

Network train_tied(const Network &network, const TrainOptions &options, Training &report) {
    if (network.layout().max_pool || network.preprocess().input != Input::whitened)
        fail(Status::unsupported, "cae: tied training takes layout %s and whitened input, this network has layout %s",
             kFlight.name, network.layout().name);
    Parameters parameters = random_parameters(network.seed());
    report.loss = fit(parameters, network.preprocess().target, options);
    report.cosine = scale_to_pixels(parameters, network.preprocess());
    if (!std::all_of(parameters.values.begin(), parameters.values.end(), [](float w) { return std::isfinite(w); }))
        fail(Status::range, "learning_rate = %g: training diverged", options.learning_rate);
    return Network(kFlight, network.preprocess(), std::move(parameters), network.seed(), true, report.cosine);
}

} // namespace toliman::cae
