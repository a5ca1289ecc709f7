#include "cae/tied.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "cae/unsupervised.hpp"
#include "kernels/decorrelate.hpp"
#include "kernels/poisson.hpp"
#include "kernels/project.hpp"
#include "kernels/random.hpp"

namespace toliman::cae {

namespace {

constexpr float kMean = 0.25f;                          // the 2x2 mean and its adjoint
constexpr float kZeroBias[kDeepChannels] = {};          // the linear passes have none
constexpr size_t kTrained = tensor_offset(kLatentBias); // convolutions and dense weights stand first
constexpr float kInertia = 0.8f;                        // share of the momentum that outlives a step
constexpr float kLinear = 0x1p-10f;  // largest activation of the decoder at 1 px: ELU bends by half of it
constexpr double kInputScale = 1e-3; // keeps the encoder's ELUs in their linear part

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

double length(const float *values, size_t count) noexcept {
    double square = 0;
    for (size_t i = 0; i < count; i++)
        square += static_cast<double>(values[i]) * values[i];
    return std::sqrt(square);
}

void scale(float *values, size_t count, double factor) noexcept {
    for (size_t i = 0; i < count; i++)
        values[i] = static_cast<float>(values[i] * factor);
}

// Squared distance of the unit target and its part along the painted image. error is that part less the target: the
// gradient of minus their cosine by the painted image, times its length.
double distance(const Buffer<double> &image, const Buffer<double> &unit, Buffer<float> &error) {
    double along = 0, square = 0;
    for (size_t i = 0; i < kPixels; i++) {
        along += image[i] * unit[i];
        square += image[i] * image[i];
    }
    const double best = square > 0 ? along / square : 0;
    for (size_t i = 0; i < kPixels; i++)
        error[i] = static_cast<float>(best * image[i] - unit[i]);
    return std::max(0.0, 1 - best * along);
}

// A trained tensor as so many values for each channel of the coarse image: where value k of channel i stands.
struct Channels {
    size_t tensor, values, channels, value_step, channel_step;
    size_t at(size_t k, size_t i) const noexcept { return k * value_step + i * channel_step; }
};

constexpr Channels channels_of(size_t stage) noexcept { // kStages: the dense weights
    if (stage == kStages)
        return {kLatentWeight, kDeepSide * kDeepSide, kDeepChannels, kDeepChannels, 1};
    const size_t values = 9 * kShapes[stage].fine_channels;
    return {conv_weight(stage), values, kShapes[stage].coarse_channels, 1, values};
}

// Turns a tensor against its momentum by at most `angle`; its length stays.
void turn(const Channels &layout, const float *momentum, double angle, float *weights) {
    const size_t values = layout.values, channels = layout.channels;
    Buffer<float> direction(values * channels), work(channels * channels);
    for (size_t k = 0; k < values; k++)
        for (size_t i = 0; i < channels; i++)
            direction[k * channels + i] = momentum[layout.at(k, i)];
    kernels::decorrelate(direction.data(), values, channels, work.data());

    const double before = length(weights, values * channels);
    const double stride = angle * before / std::sqrt(static_cast<double>(channels));
    for (size_t k = 0; k < values; k++)
        for (size_t i = 0; i < channels; i++)
            weights[layout.at(k, i)] -= static_cast<float>(stride * direction[k * channels + i]);
    scale(weights, values * channels, before / length(weights, values * channels));
}

// The target's direction. Status::state where it has none.
Buffer<double> unit_of(const Buffer<double> &target) {
    const double size = norm(target);
    if (!(size > 0))
        fail(Status::state, "cae: the scene's derivative image is zero: there is nothing to train on");
    Buffer<double> unit = target;
    for (double &value : unit)
        value /= size;
    return unit;
}

// Turns the linear decoder's image into the target's direction.
void fit(const Buffer<double> &target, const TiedOptions &options, Training &state) {
    const Buffer<double> unit = unit_of(target);
    Images forward, backward;
    Parameters gradient;
    Buffer<float> error(kPixels);
    paint(state.weights, forward);
    state.loss = distance(painted(forward), unit, error);
    Training next = state; // a step counts as a whole or not at all
    while (state.done < options.steps) {
        put_inside(error.data(), kSide, kSide, 1, backward[0]);
        backward_pass(next.weights, forward, backward, gradient);
        for (size_t i = 0; i < kTrained; i++)
            next.first.values[i] = kInertia * next.first.values[i] + gradient.values[i];
        const double left = 1 - static_cast<double>(state.done) / options.steps;
        for (size_t s = 0; s <= kStages; s++) {
            const Channels layout = channels_of(s);
            turn(layout, next.first[layout.tensor], options.learning_rate * left, next.weights[layout.tensor]);
        }
        paint(next.weights, forward);
        next.loss = distance(painted(forward), unit, error);
        next.steps = ++next.done;
        state = next;
        options.losses.put(state.done - 1, state.loss);
        char stage[96];
        print_text(stage, sizeof stage, "train: step %u of %u, loss %.4f, cosine %.4f", state.done, options.steps,
                   state.loss, std::sqrt(std::max(0.0, 1 - state.loss)));
        options.progress.report(stage, static_cast<double>(state.done) / options.steps);
    }
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

bool can_be_tied(const Layout &layout, Input input) noexcept {
    return !layout.max_pool && input == Input::whitened;
}

Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed) {
    if (!can_be_tied(layout, preprocess.input))
        return Network(layout, std::move(preprocess), initial_weights(seed), seed, false, 0);
    preprocess.input_scale = kInputScale;
    Parameters parameters = random_parameters(seed);
    scale_to_pixels(parameters, preprocess);
    return Network(layout, std::move(preprocess), std::move(parameters), seed, false, 0);
}

Network train_tied(const Network &network, const TiedOptions &options, Training &state) {
    const Layout &layout = network.layout();
    const Input input = network.preprocess().input;
    if (!can_be_tied(layout, input))
        fail(Status::unsupported, "cae: tied training takes layout %s and whitened input, not layout %s and %s input",
             kFlight.name, layout.name, name_of(input));
    Preprocess preprocess = network.preprocess().with_input_scale(kInputScale);
    if (state.done == 0)
        state.weights = random_parameters(network.seed());
    fit(preprocess.target, options, state);
    Parameters parameters = state.weights;
    const double cosine = scale_to_pixels(parameters, preprocess);
    if (!std::all_of(parameters.values.begin(), parameters.values.end(), [](float w) { return std::isfinite(w); }))
        fail(Status::range, "cae: a derivative image of length %g px^-1: the weights that it takes are not finite",
             norm(preprocess.target));
    return Network(layout, std::move(preprocess), std::move(parameters), network.seed(), true, cosine);
}

} // namespace toliman::cae
