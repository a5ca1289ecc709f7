// Method: minimises mean (decoder output - input)^2 by Adam over shuffled mini-batches, without a prior on the signal.
// Initial weights are normal with variance 1/inputs, which keeps the variance of activations of linear layers.
//
// Determinism: the order of an epoch is a Fisher-Yates shuffle from (seed, epoch) alone, and a batch is summed in eight
// slots of fixed membership, regardless of the number of workers. Runs on 1 or 8 threads, and interrupted and
// uninterrupted ones, therefore give the same bits. All inputs are held in memory as float32, 256 KiB per frame
// (`core`: 64 KiB).
//
// The mode reproduces the book chapter's training and serves as a control: the loss is dominated by the image, not by
// the displacement, and the network found a signal of 1e-4 px at a sixth of the epochs and one of 1e-6 px at none of
// 1,000 (tools/docs/benchmarks.md). Use tied training (cae/tied.hpp) to detect signals.
//
// Reference: Kingma and Ba (2015), "Adam", ICLR.
#include "cae/unsupervised.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "base/text.hpp"
#include "base/workers.hpp"
#include "cae/backward.hpp"
#include "cae/payload.hpp"
#include "kernels/adam.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"

namespace toliman::cae {

namespace {

// Partial sums of a batch: at most this many workers share it. Fixed, so that the result does not depend on the
// workers.
constexpr size_t kSlots = 8;
constexpr double kInputScale = 1;          // the decoder has to reproduce the unscaled input
constexpr size_t kPixelsAtOnce = 1u << 21; // pixels per request for frames, but at least one frame

// Random permutation of 0 ... count - 1 (Fisher-Yates). Epochs count from 1; 0 splits off the validation frames.
Buffer<size_t> shuffled(size_t count, uint64_t seed, uint64_t epoch) {
    kernels::Rng rng(seed + 0x9e3779b97f4a7c15u * epoch, kernels::kStreamShuffle);
    Buffer<size_t> order(count);
    std::iota(order.begin(), order.end(), size_t{0});
    for (size_t i = count; i > 1; i--)
        std::swap(order[i - 1], order[static_cast<size_t>(rng.uniform() * static_cast<double>(i))]);
    return order;
}

// The network's inputs of all frames, float32 [frames][pixels].
Buffer<float> read_inputs(const Preprocess &preprocess, const UnsupervisedOptions &options, const FrameSource &frames) {
    const size_t rows = preprocess.rows, cols = preprocess.cols, pixels = preprocess.pixels();
    const size_t at_once = std::clamp<size_t>(kPixelsAtOnce / (rows * cols), 1, options.frames);
    Buffer<float> inputs(options.frames * pixels);
    Buffer<double> counts(at_once * rows * cols);
    Preprocess::Work work;
    for (size_t first = 0; first < options.frames; first += at_once) {
        const size_t count = std::min(at_once, options.frames - first);
        frames(first, count, counts.data());
        for (size_t i = 0; i < count; i++)
            in_frame(first + i, [&] {
                const double *frame = &counts[i * rows * cols];
                preprocess.apply({frame, rows, cols, cols}, work, &inputs[(first + i) * pixels]);
                if (std::all_of(frame, frame + rows * cols, [&](double value) { return value == frame[0]; }))
                    fail(Status::argument, "{counts}: all pixels are %g: must not all be equal", frame[0]);
            });
        options.progress.report("frames", static_cast<double>(first + count) / static_cast<double>(options.frames));
    }
    return inputs;
}

// Mean squared error of the decoder output; gradient[0] = share times the error, where share may be 0.
double squared_error(const Layout &layout, const float *input, const Images &decoder, float share, Images &gradient) {
    double sum = 0;
    for (size_t r = 0; r < layout.side; r++) {
        const size_t at = layout.input_at(r);
        for (size_t c = 0; c < layout.side; c++) {
            const float error = decoder[0][at + c] - input[r * layout.side + c];
            sum += static_cast<double>(error) * static_cast<double>(error);
            gradient[0][at + c] = share * error;
        }
    }
    return sum / static_cast<double>(layout.pixels());
}

class Trainer {
  public:
    Trainer(const Network &network, const UnsupervisedOptions &options, const Buffer<float> &inputs)
        : layout_(network.layout()), options_(options), inputs_(inputs), total_(layout_), gradient_(layout_) {
        for (size_t i = 0; i < kSlots; i++) {
            passes_.push_back(std::make_unique<Pass>(layout_));
            slots_.push_back(std::make_unique<Gradient>(layout_));
        }
    }

    // Returns the mean loss of the images and, if requested, leaves their mean gradient in total_.
    double run(const Parameters &weights, const Operators &operators, const size_t *images, size_t count,
               bool with_gradient) {
        std::array<double, kSlots> losses = {};
        run_jobs(worker_count(options_.workers), kSlots, [&](size_t slot) {
            slots_[slot]->clear();
            for (size_t i = slot; i < count; i += kSlots)
                losses[slot] += pass_image(weights, operators, &inputs_[images[i] * layout_.pixels()],
                                           with_gradient ? 1.0 / static_cast<double>(count) : 0, slot);
        });
        total_.clear();
        for (size_t slot = 0; with_gradient && slot < kSlots; slot++)
            total_.add(*slots_[slot]);
        return std::accumulate(losses.begin(), losses.end(), 0.0) / static_cast<double>(count);
    }

    // One optimiser step on a batch; returns its mean loss.
    double step(Training &state, const size_t *images, size_t count) {
        const Operators operators(state.weights);
        const double loss = run(state.weights, operators, images, count, true);
        check(loss, state.done + 1);
        total_.get(gradient_);
        state.steps++;
        kernels::adam(state.steps, options_.learning_rate, gradient_.values.data(), layout_.parameters(),
                      state.first.values.data(), state.second.values.data(), state.weights.values.data());
        return loss;
    }

    // Fails unless the loss is a number that the weights blob can store.
    void check(double loss, uint32_t epoch) const {
        if (!(loss <= kMaxMagnitude))
            fail(Status::range, "{learning_rate} = %g: training diverged in epoch %u", options_.learning_rate, epoch);
    }

  private:
    double pass_image(const Parameters &weights, const Operators &operators, const float *input, double share,
                      size_t slot) const {
        Pass &pass = *passes_[slot];
        put_inside(input, layout_.side, layout_.side, 1, pass.encoder[0]);
        pass.latent = static_cast<float>(encode(weights, operators.encoder_down, pass.encoder, &pass.pooling));
        decode(weights, operators.decoder_up, pass.latent, pass.decoder, pass.pooling);
        const auto factor = static_cast<float>(2 * share / static_cast<double>(layout_.pixels()));
        const double loss = squared_error(layout_, input, pass.decoder, factor, pass.gradient);
        if (share != 0)
            slots_[slot]->add(weights, operators, pass);
        return loss;
    }

    const Layout &layout_;
    const UnsupervisedOptions &options_;
    const Buffer<float> &inputs_;
    std::vector<std::unique_ptr<Pass>> passes_;
    std::vector<std::unique_ptr<Gradient>> slots_;
    Gradient total_;
    Parameters gradient_;
};

struct Split {
    Buffer<size_t> training, validation;
};

Split split(uint64_t seed, size_t frames, size_t validation) {
    const Buffer<size_t> order = shuffled(frames, seed, 0);
    Split split;
    split.validation.assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(validation));
    split.training.assign(order.begin() + static_cast<std::ptrdiff_t>(validation), order.end());
    std::sort(split.validation.begin(), split.validation.end());
    std::sort(split.training.begin(), split.training.end());
    return split;
}

} // namespace

Parameters initial_weights(const Layout &layout, uint64_t seed) {
    kernels::Rng rng(seed, kernels::kStreamWeights);
    Parameters parameters(layout);
    const auto draw = [&](size_t tensor, size_t inputs) {
        const double sigma = 1 / std::sqrt(static_cast<double>(inputs));
        std::generate_n(parameters[tensor], layout.tensors[tensor].count(),
                        [&] { return static_cast<float>(sigma * rng.normal()); });
    };
    for (size_t s = 0; s < kStages; s++)
        draw(conv_weight(s), 9 * kChannels[s]);
    draw(kLatentWeight, layout.features());
    draw(kExpandWeight, 1);
    for (size_t s = kStages; s-- > 0;)
        draw(deconv_weight(s), 9 * kChannels[s + 1]);
    return parameters;
}

void train_unsupervised(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames,
                        Training &state) {
    if (state.done == 0)
        state.weights = initial_weights(network.layout(), network.seed());
    const Split split = cae::split(network.seed(), options.frames, options.validation);
    const Buffer<float> inputs = read_inputs(network.preprocess().with_input_scale(kInputScale), options, frames);
    Trainer trainer(network, options, inputs);
    const size_t images = split.training.size();
    while (state.done < options.epochs) {
        Training next = state;
        const Buffer<size_t> permutation = shuffled(images, network.seed(), state.done + 1);
        Buffer<size_t> order(images);
        std::transform(permutation.begin(), permutation.end(), order.begin(),
                       [&](size_t i) { return split.training[i]; });
        double loss = 0;
        for (size_t at = 0; at < images; at += options.batch) {
            const size_t count = std::min<size_t>(options.batch, images - at);
            loss += trainer.step(next, &order[at], count) * static_cast<double>(count);
            char stage[128];
            const size_t size = print_text(stage, sizeof stage, "train: epoch %u of %u, loss %.4g", state.done + 1,
                                           options.epochs, loss / static_cast<double>(at + count));
            if (state.done > 0)
                print_text(stage + size, sizeof stage - size, ", validation %.4g", state.validation_loss);
            options.progress.report(
                stage, (state.done + static_cast<double>(at + count) / static_cast<double>(images)) / options.epochs);
        }
        next.loss = loss / static_cast<double>(images);
        const Operators operators(next.weights);
        next.validation_loss =
            trainer.run(next.weights, operators, split.validation.data(), split.validation.size(), false);
        trainer.check(next.validation_loss, next.done + 1);
        next.done++;
        state = next;
        options.losses.put(state.done - 1, state.loss);
        if (options.epoch)
            options.epoch(state);
    }
}

Network trained_network(const Network &network, const Training &state) {
    return Network(network.preprocess().with_input_scale(kInputScale), state.weights, network.seed(), true, 0);
}

Quality validate(const Network &network, const UnsupervisedOptions &options, const FrameSource &frames) {
    const Buffer<size_t> held_out = split(network.seed(), options.frames, options.validation).validation;
    const Preprocess &preprocess = network.preprocess();
    Buffer<double> counts(preprocess.rows * preprocess.cols), image(preprocess.pixels());
    Quality sum = {};
    const ImageView<const double> view = {counts.data(), preprocess.rows, preprocess.cols, preprocess.cols};
    const double share = 1 / static_cast<double>(held_out.size());
    for (size_t i = 0; i < held_out.size(); i++) {
        options.progress.report("validate", static_cast<double>(i) * share);
        frames(held_out[i], 1, counts.data());
        Quality one = {};
        in_frame(held_out[i], [&] {
            network.reconstruct(view, image.data());
            one = quality(network, view, image.data());
        });
        sum.mmse += one.mmse * share;
        sum.mssim += one.mssim * share;
        sum.photon_floor += one.photon_floor * share;
    }
    return sum;
}

} // namespace toliman::cae
