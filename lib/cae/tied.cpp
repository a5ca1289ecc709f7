// Method: while ELU is linear, the encoder is latent = <g, residual>, where g is the output image of the linear decoder
// with the encoder's own weights (its adjoint). The best linear estimate of a small displacement from white noise has g
// parallel to the whitened, projected derivative image w (matched filter). Training therefore fits the image g to w:
//     loss = 1 - cos^2(g, w),    cos(g, w) = the efficiency to expect
// It needs neither frames nor noise. Finally the latent is scaled to px, and the decoder's weights are set so that its
// output for 1 px has the projection |w| on w.
//
// Step: each tensor W is a matrix with one column per coarse channel. With its momentum m <- 0.8 m + gradient and O its
// orthogonalised columns (kernels/decorrelate.hpp),
//     W <- W - angle |W|/sqrt(columns) O, rescaled to its former norm;    angle falls linearly to 0
// A few dominant directions of the gradient then do not use up the whole step. As the norm is constant, no learning
// rate diverges.
//
// Rejected: Adam, which reached cosines of 0.96 (chapter scene) and 0.93 (mission scene) in 600 steps, against 0.99 in
// 300 steps here, and whose latent was four times as nonlinear. Training on noisy frames with clean ones as the target:
// an efficiency of 0.68 from random weights, in a prototype.
//
// Reference: Jordan et al. (2024), "Muon: an optimizer for hidden layers in neural networks".
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

constexpr float kMean = 0.25f;             // the 2x2 mean and its adjoint
constexpr float kMomentum = 0.8f;          // fraction of the momentum kept per step
constexpr float kMaxActivation = 0x1p-10f; // of the decoder at 1 px: ELU(x) = x + x^2/2 + ..., so 0.05 % from linear
constexpr double kTiedInputScale = 1e-3;   // keeps the encoder's activations small, where ELU is nearly linear

// Random start: convolution kernels with orthonormal rows [coarse][9 fine], Gaussian dense weights of norm
// sqrt(features), biases 0.
Parameters random_parameters(const Layout &layout, uint64_t seed) {
    kernels::Rng rng(seed, kernels::kStreamWeights);
    Parameters parameters(layout);
    for (size_t s = 0; s < kStages; s++) {
        const size_t rows = kChannels[s + 1], cols = 9 * kChannels[s];
        Buffer<double> kernel(rows * cols);
        std::generate(kernel.begin(), kernel.end(), [&] { return rng.normal(); });
        kernels::orthonormalise(kernel.data(), rows, cols);
        std::transform(kernel.begin(), kernel.end(), parameters[conv_weight(s)],
                       [](double value) { return static_cast<float>(value); });
    }
    const size_t features = layout.features();
    Buffer<double> dense(features);
    std::generate(dense.begin(), dense.end(), [&] { return rng.normal(); });
    const double norm = std::sqrt(kernels::dot(dense.data(), dense.data(), features) / static_cast<double>(features));
    std::transform(dense.begin(), dense.end(), parameters[kLatentWeight],
                   [norm](double value) { return static_cast<float>(value / norm); });
    return parameters;
}

// Runs the linear decoder with the encoder's own tensors. Its image is also d latent/d input of the encoder at zero
// input: without biases every ELU is at 0, where its slope is 1.
void decode_linear(const Parameters &parameters, Images &images) {
    const Layout &layout = *parameters.layout;
    put_inside(parameters[kLatentWeight], layout.deep_side(), layout.deep_side(), kDeepChannels, images[kStages]);
    Buffer<float> packed;
    for (size_t s = kStages; s-- > 0;) {
        const kernels::ConvShape &shape = layout.shapes[s];
        packed.resize(shape.packed());
        kernels::conv_pack_up(shape, parameters[conv_weight(s)], kMean, packed.data());
        kernels::conv_kernels().up(shape, images[s + 1], packed.data(), kZeroBias, images[s]);
    }
}

void get_decoded(const Layout &layout, const Images &images, Buffer<double> &image) {
    image.resize(layout.pixels());
    for (size_t r = 0; r < layout.side; r++)
        std::copy_n(images[0] + layout.input_at(r), layout.side, &image[r * layout.side]);
}

// Gradient with respect to the trained tensors, from that with respect to the decoded image in backward[0].
void backward_pass(const Parameters &parameters, Images &forward, Images &backward, Parameters &gradient) {
    const Layout &layout = *parameters.layout;
    Buffer<float> packed;
    for (size_t s = 0; s < kStages; s++) {
        const kernels::ConvShape &shape = layout.shapes[s];
        packed.resize(shape.packed());
        kernels::conv_kernels().weight_gradient(shape, backward[s], forward[s + 1], packed.data());
        kernels::conv_unpack_gradient(shape, packed.data(), kMean, gradient[conv_weight(s)]);
        kernels::conv_pack_down(shape, parameters[conv_weight(s)], kMean, packed.data());
        kernels::conv_kernels().down(shape, backward[s], packed.data(), kZeroBias, backward[s + 1]);
    }
    get_inside(backward[kStages], layout.deep_side(), layout.deep_side(), kDeepChannels, gradient[kLatentWeight]);
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

// Returns 1 - cosine^2 of image and unit target: their squared distance after the best scaling of the image. error is
// the scaled image minus the target, which is the gradient of -cosine with respect to the image, times the image's
// norm.
double distance(const Buffer<double> &image, const Buffer<double> &unit, Buffer<float> &error) {
    double along = 0, square = 0;
    for (size_t i = 0; i < unit.size(); i++) {
        along += image[i] * unit[i];
        square += image[i] * image[i];
    }
    const double best = square > 0 ? along / square : 0;
    for (size_t i = 0; i < unit.size(); i++)
        error[i] = static_cast<float>(best * image[i] - unit[i]);
    return std::max(0.0, 1 - best * along);
}

// Layout of a trained tensor as a matrix [values][channels], one column per channel of the coarse image. at(k, i) is
// the offset of value k of channel i.
struct Channels {
    size_t tensor, values, channels, value_step, channel_step;
    size_t at(size_t k, size_t i) const noexcept { return k * value_step + i * channel_step; }
};

constexpr Channels channels_of(const Layout &layout, size_t stage) noexcept { // kStages: the dense weights
    if (stage == kStages)
        return {kLatentWeight, layout.deep_side() * layout.deep_side(), kDeepChannels, kDeepChannels, 1};
    const size_t values = 9 * kChannels[stage];
    return {conv_weight(stage), values, kChannels[stage + 1], 1, values};
}

// Steps against the orthogonalised momentum by at most `angle` times the tensor's norm, then restores the norm: a
// rotation by about `angle` (rad) at most. The columns of `direction` have at most unit length, so its norm is at most
// sqrt(channels).
void rotate(const Channels &of, const float *momentum, double angle, float *weights) {
    const size_t values = of.values, channels = of.channels;
    Buffer<float> direction(values * channels), work(channels * channels);
    for (size_t k = 0; k < values; k++)
        for (size_t i = 0; i < channels; i++)
            direction[k * channels + i] = momentum[of.at(k, i)];
    kernels::decorrelate_kernels().decorrelate(direction.data(), values, channels, work.data());

    const double before = length(weights, values * channels);
    const double stride = angle * before / std::sqrt(static_cast<double>(channels));
    for (size_t k = 0; k < values; k++)
        for (size_t i = 0; i < channels; i++)
            weights[of.at(k, i)] -= static_cast<float>(stride * direction[k * channels + i]);
    scale(weights, values * channels, before / length(weights, values * channels));
}

// The target, normalised. Status::state for a zero target.
Buffer<double> unit_of(const Buffer<double> &target) {
    const double size = norm(target);
    if (!(size > 0))
        fail(Status::state, "cae: the scene's derivative image is zero: it must have a signal to train on");
    Buffer<double> unit = target;
    for (double &value : unit)
        value /= size;
    return unit;
}

// Number of weights that are trained: the first tensors, convolutions and dense weights.
constexpr size_t trained_of(const Layout &layout) noexcept {
    return layout.offsets[kLatentBias];
}

// state = next; only the trained tensors differ.
void accept(const Training &next, Training &state) noexcept {
    const size_t trained = trained_of(*state.weights.layout);
    std::copy_n(next.weights.values.begin(), trained, state.weights.values.begin());
    std::copy_n(next.first.values.begin(), trained, state.first.values.begin());
    state.steps = next.steps;
    state.done = next.done;
    state.loss = next.loss;
}

// Rotates the linear decoder's image towards the target, from state on until options.steps are done.
void fit(const Buffer<double> &target, const TiedOptions &options, Training &state) {
    const Layout &layout = *state.weights.layout;
    const size_t trained = trained_of(layout);
    const Buffer<double> unit = unit_of(target);
    Images forward(layout), backward(layout);
    Parameters gradient(layout);
    Buffer<float> error(layout.pixels());
    Buffer<double> image;
    decode_linear(state.weights, forward);
    get_decoded(layout, forward, image);
    state.loss = distance(image, unit, error);
    Training next = state; // so that a step that fails or is cancelled leaves state as it was
    while (state.done < options.steps) {
        put_inside(error.data(), layout.side, layout.side, 1, backward[0]);
        backward_pass(next.weights, forward, backward, gradient);
        for (size_t i = 0; i < trained; i++)
            next.first.values[i] = kMomentum * next.first.values[i] + gradient.values[i];
        const double remaining = 1 - static_cast<double>(state.done) / options.steps;
        for (size_t s = 0; s <= kStages; s++) {
            const Channels of = channels_of(layout, s);
            rotate(of, next.first[of.tensor], options.learning_rate * remaining, next.weights[of.tensor]);
        }
        decode_linear(next.weights, forward);
        get_decoded(layout, forward, image);
        next.loss = distance(image, unit, error);
        next.steps = ++next.done;
        accept(next, state);
        options.losses.put(state.done - 1, state.loss);
        char stage[96];
        print_text(stage, sizeof stage, "train: step %u of %u, loss %.4f, cosine %.4f", state.done, options.steps,
                   state.loss, std::sqrt(std::max(0.0, 1 - state.loss)));
        options.progress.report(stage, static_cast<double>(state.done) / options.steps);
    }
}

// 1/value, or 1 where that is not finite.
double reciprocal(double value) noexcept {
    return std::isfinite(1 / value) && value != 0 ? 1 / value : 1;
}

// Sets the decoder to the encoder's adjoint. Each tensor is scaled so that activations reach at most kMaxActivation at
// 1 px, and the last one so that the output image for 1 px has the inner product |target|^2 with the target.
void set_decoder(Parameters &parameters, const Buffer<double> &target) {
    const Layout &layout = *parameters.layout;
    Images images(layout);
    size_t tensor_size = layout.features();
    std::copy_n(parameters[kLatentWeight], tensor_size, parameters[kExpandWeight]);
    float *tensor = parameters[kExpandWeight];
    put_inside(tensor, layout.deep_side(), layout.deep_side(), kDeepChannels, images[kStages]);
    Buffer<float> packed;
    for (size_t s = kStages; s-- > 0;) {
        const kernels::ConvShape &shape = layout.shapes[s];
        float largest = 0;
        for (size_t i = 0; i < layout.level_size(s + 1); i++)
            largest = std::max(largest, std::fabs(images[s + 1][i]));
        const double factor = kMaxActivation * reciprocal(largest);
        scale(tensor, tensor_size, factor);
        scale(images[s + 1], layout.level_size(s + 1), factor);

        tensor = parameters[deconv_weight(s)];
        tensor_size = layout.tensors[deconv_weight(s)].count();
        std::copy_n(parameters[conv_weight(s)], tensor_size, tensor);
        packed.resize(shape.packed());
        kernels::conv_pack_up(shape, tensor, 1.0f, packed.data());
        kernels::conv_kernels().up(shape, images[s + 1], packed.data(), kZeroBias, images[s]);
    }
    Buffer<double> image;
    get_decoded(layout, images, image);
    scale(tensor, tensor_size,
          kernels::dot(target.data(), target.data(), target.size()) *
              reciprocal(kernels::dot(image.data(), target.data(), target.size())));
}

// Scales encoder and decoder to a latent in px; returns the cosine of d latent/d residual and the target.
double scale_to_pixels(Parameters &parameters, const Preprocess &preprocess) {
    Buffer<double> slope = gradient_of(parameters);
    const size_t pixels = slope.size();
    kernels::project_out(preprocess.nuisance_basis.data(), preprocess.projected, pixels, slope.data());
    const double along = kernels::dot(slope.data(), preprocess.target.data(), pixels);
    scale(parameters[kLatentWeight], parameters.layout->features(), reciprocal(preprocess.input_scale * along));
    set_decoder(parameters, preprocess.target);
    return std::min(1.0, std::fabs(along) * reciprocal(norm(slope) * norm(preprocess.target)));
}

} // namespace

bool can_be_tied(const Layout &layout, Input input) noexcept {
    return !layout.max_pool && input == Input::whitened;
}

Network untrained_network(const Layout &layout, Preprocess preprocess, uint64_t seed) {
    if (!can_be_tied(layout, preprocess.input))
        return Network(std::move(preprocess), initial_weights(layout, seed), seed, false, 0);
    preprocess.input_scale = kTiedInputScale;
    Parameters parameters = random_parameters(layout, seed);
    scale_to_pixels(parameters, preprocess);
    return Network(std::move(preprocess), std::move(parameters), seed, false, 0);
}

Parameters random_encoder(const Layout &layout, uint64_t seed) {
    return random_parameters(layout, seed);
}

double train_encoder(const Buffer<double> &target, const TiedOptions &options, Parameters &weights) {
    Training state(*weights.layout);
    state.weights = weights;
    fit(target, options, state);
    weights = state.weights;
    return std::sqrt(std::max(0.0, 1 - state.loss));
}

Buffer<double> gradient_of(const Parameters &weights) {
    Images images(*weights.layout);
    decode_linear(weights, images);
    Buffer<double> image;
    get_decoded(*weights.layout, images, image);
    return image;
}

Network train_tied(const Network &network, const TiedOptions &options, Training &state) {
    const Layout &layout = network.layout();
    const Input input = network.preprocess().input;
    if (!can_be_tied(layout, input))
        fail(Status::unsupported,
             "cae: layout = %s, input = %s: tied training requires layout %s or %s and input whitened", layout.name,
             name_of(input), kFlight.name, kCore.name);
    Preprocess preprocess = network.preprocess().with_input_scale(kTiedInputScale);
    if (state.done == 0)
        state.weights = random_parameters(layout, network.seed());
    fit(preprocess.target, options, state);
    Parameters parameters = state.weights;
    const double cosine = scale_to_pixels(parameters, preprocess);
    if (!std::all_of(parameters.values.begin(), parameters.values.end(), [](float w) { return std::isfinite(w); }))
        fail(Status::range, "cae: norm of the derivative image = %g px^-1: the trained weights are not finite",
             norm(preprocess.target));
    return Network(std::move(preprocess), std::move(parameters), network.seed(), true, cosine);
}

} // namespace toliman::cae
