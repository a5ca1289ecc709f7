// Measures the autoencoder on one core with each instruction set and prints one JSON object per line. cae.py runs this
// program, prints the table and adds the reference implementations. Times are medians of processor time. With a folder
// as argument, the program also writes raw float32 files for the references to compare with: weights and an image, and
// for each instruction set the network's latent, output and loss gradient.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <toliman/cae.h>
#include <toliman/linear.h>
#include <toliman/sim.h>

#include "cae/backward.hpp"
#include "cae/network.hpp"
#include "cae/unsupervised.hpp"
#include "cae/weights.hpp"
#include "chosen_isa.hpp"
#include "kernels/adam.hpp"
#include "kernels/same_conv.hpp"
#include "peak.h"
#include "timing.hpp"

using namespace toliman::cae;

namespace {

using toliman::Buffer;
using toliman::kernels::chosen;
using toliman::kernels::Isa;
using toliman::kernels::runs;

constexpr int kRepeats = 9;
constexpr size_t kFrames = 20, kBatch = 16;

timing time_of(int calls, const std::function<void()> &work) {
    work();
    return measure(kRepeats, calls, work);
}

void check(toliman_status status) {
    if (status != TOLIMAN_OK) {
        std::fprintf(stderr, "bench_cae: %s\n", toliman_last_error());
        std::exit(1);
    }
}

volatile float sink;

// Peak rate of an instruction set: the highest of all samples so far.
struct Peak {
    double sample() {
        gflops = std::max(gflops, peak_float(static_cast<peak_isa>(isa)));
        return gflops;
    }
    Isa isa;
    double gflops = 0;
};

// Minimal number of operations of a stage's convolution, in millions, for the algorithm in use. Per coarse pixel and
// pair of channels, a mean needs 9 products (it is taken first). `paper` needs 36 (its 2x2 fine pixels), or 16
// in Winograd's form. The gradient with respect to the weights has no Winograd form.
double mflop(const Layout &layout, size_t stage, bool by_weights = false) {
    const toliman::kernels::ConvShape &s = layout.shapes[stage];
    const toliman::kernels::SameShape same = {2 * s.rows, 2 * s.cols, s.fine_channels, s.coarse_channels};
    const size_t products = !layout.max_pool ? 9 : same.winograd() && !by_weights ? 16 : 36;
    return 2e-6 * static_cast<double>(products * s.rows * s.cols * s.fine_channels * s.coarse_channels);
}

double encoding_mflop(const Layout &layout) {
    double sum = 0;
    for (size_t s = 0; s < kStages; s++)
        sum += mflop(layout, s);
    return sum;
}

// Forward pass and gradient with respect to the images in encoder and decoder, except the gradient with respect to the
// first image; gradient with respect to the weights of both.
double training_mflop(const Layout &layout) {
    double sum = -mflop(layout, 0);
    for (size_t s = 0; s < kStages; s++)
        sum += 4 * mflop(layout, s) + 2 * mflop(layout, s, true);
    return sum;
}

void write(const std::string &path, const float *values, size_t count) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char *>(values), static_cast<std::streamsize>(4 * count));
}

// Forward and backward pass of one image, as in unsupervised training.
struct Step {
    explicit Step(const Layout &which)
        : layout(which), weights(initial_weights(which, 3)), result(which), mean(which), square(which),
          operators(weights), pass(which), gradient(which), input(which.pixels()) {
        for (size_t i = 0; i < layout.pixels(); i++)
            input[i] = static_cast<float>(std::sin(0.37 * static_cast<double>(i % layout.side)) *
                                          std::cos(0.23 * static_cast<double>(i / layout.side)));
    }
    void image() {
        put_inside(input.data(), layout.side, layout.side, 1, pass.encoder[0]);
        pass.latent = static_cast<float>(encode(weights, operators.encoder_down, pass.encoder, &pass.pooling));
        decode(weights, operators.decoder_up, pass.latent, pass.decoder, pass.pooling);
        const auto pixels = static_cast<float>(layout.pixels());
        for (size_t r = 0; r < layout.side; r++)
            for (size_t c = 0; c < layout.side; c++) {
                const size_t at = layout.input_at(r) + c;
                pass.gradient[0][at] = (pass.decoder[0][at] - input[r * layout.side + c]) * (2 / pixels);
            }
        gradient.add(weights, operators, pass);
    }
    // One batch and its Adam step.
    void batch() {
        operators = Operators(weights);
        gradient.clear();
        for (size_t i = 0; i < kBatch; i++)
            image();
        gradient.get(result);
        steps++;
        toliman::kernels::adam(steps, 1e-6, result.values.data(), layout.parameters(), mean.values.data(),
                               square.values.data(), weights.values.data());
    }
    const Layout &layout;
    Parameters weights, result, mean, square;
    Operators operators;
    Pass pass;
    Gradient gradient;
    Buffer<float> input;
    size_t steps = 0;
};

void write_for_peers(const std::string &folder, const Layout &layout) {
    Step step(layout);
    step.image();
    step.gradient.get(step.result);
    const std::string name = folder + "/" + layout.name;
    write(name + ".weights", step.weights.values.data(), layout.parameters());
    write(name + ".input", step.input.data(), layout.pixels());
    const std::string ours = name + "-" + toliman::kernels::host_isa_name();
    write(ours + ".latent", &step.pass.latent, 1);
    write(ours + ".gradient", step.result.values.data(), layout.parameters());
    std::vector<float> out(layout.pixels());
    get_inside(step.pass.decoder[0], layout.side, layout.side, 1, out.data());
    write(ours + ".output", out.data(), out.size());
}

// The book chapter's scene with frames of the layout's size.
std::string scene_text(const Layout &layout) {
    const std::string shape = "\"shape\": [256, 256]", side = std::to_string(layout.side);
    std::ifstream stream("examples/scenes/chapter.json");
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    const size_t at = text.find(shape);
    if (at == std::string::npos) {
        std::fprintf(stderr, "bench_cae: examples/scenes/chapter.json: no %s\n", shape.c_str());
        std::exit(1);
    }
    return text.replace(at, shape.size(), "\"shape\": [" + side + ", " + side + "]");
}

struct Scene {
    explicit Scene(const Layout &layout) : pixels(layout.pixels()) {
        const std::string text = scene_text(layout);
        check(toliman_sim_create_json(text.data(), text.size(), "examples/scenes", nullptr, &sim));
        check(toliman_cae_create(sim, 1, nullptr, &cae));
        check(toliman_cae_train(cae, nullptr, nullptr));
        info.struct_size = sizeof info;
        check(toliman_cae_get_info(cae, nullptr, &info));
        const std::vector<double> still(kFrames, 0.0);
        check(toliman_sim_frame(sim, still.data(), 1, 0, kFrames, frames.data()));
        size_t size;
        check(toliman_cae_save(cae, nullptr, nullptr, 0, &size) == TOLIMAN_E_CAPACITY ? TOLIMAN_OK
                                                                                      : TOLIMAN_E_INTERNAL);
        blob.resize(size);
        check(toliman_cae_save(cae, nullptr, blob.data(), size, &size));
        latents.resize(kFrames);
        const toliman_image image = first_frames();
        check(toliman_cae_encode(cae, &image, kFrames, latents.data(), nullptr));
    }
    Scene(const Scene &) = delete;
    Scene &operator=(const Scene &) = delete;
    ~Scene() {
        toliman_cae_destroy(cae);
        toliman_sim_destroy(sim);
    }
    toliman_image first_frames() const {
        toliman_image image = {};
        image.struct_size = sizeof image;
        image.pixels = frames.data();
        return image;
    }
    const size_t pixels; // of a frame
    toliman_sim *sim = nullptr;
    toliman_cae *cae = nullptr;
    toliman_cae_info info = {};
    std::vector<double> frames = std::vector<double>(kFrames * pixels);
    std::vector<double> latents;
    std::vector<uint8_t> blob;
};

void measure_encode(const Scene &scene, const Layout &layout, Peak &peak) {
    const Network trained = from_blob(scene.blob.data(), scene.blob.size()).network;
    // The weights of `flight` fit `paper`. Their quality does not matter: only the time is measured.
    Parameters weights(layout);
    weights.values = trained.parameters().values;
    const Network network(trained.preprocess(), weights, 1, true, 0);
    const size_t side = layout.side;
    const toliman::ImageView<const double> frame = {scene.frames.data(), side, side, side};
    Buffer<float> input(layout.pixels());
    Preprocess::Work scratch;
    toliman::cae::Workspace work;
    const auto projecting = [&](size_t planes) { // any images: the time does not depend on their content
        Preprocess blind = network.preprocess();
        blind.projected = planes;
        blind.nuisance_basis.assign(planes * layout.pixels(), 1.0 / static_cast<double>(side));
        blind.derive();
        return Network(blind, weights, 1, true, 0);
    };
    constexpr size_t kPlanes[] = {4, 8, 20, 32}, kCounts = sizeof kPlanes / sizeof *kPlanes;
    std::vector<Network> with;
    for (const size_t planes : kPlanes)
        with.push_back(projecting(planes));
    const toliman::PixelFrames frames = {toliman::Pixel::f64, scene.frames.data(), side, side, side, layout.pixels()};
    double latents[kFrames];
    const auto many = [&](const Network &which) {
        return [&] { which.encode_many(frames, kFrames, 1, latents, nullptr); };
    };
    peak.sample();
    const auto plain = [&] { sink = static_cast<float>(network.encode(frame, work)); };
    plain(), many(network)();
    double times[kRepeats], series[kRepeats], more[kCounts][kRepeats]; // in turn, so that all see the same clock rate
    for (int i = 0; i < kRepeats; i++) {
        times[i] = measure(1, 20, plain).median;
        series[i] = measure(1, 1, many(network)).median / kFrames;
        for (size_t k = 0; k < kCounts; k++)
            more[k][i] = measure(1, 1, many(with[k])).median / kFrames - series[i];
    }
    const timing whole = timing_of(times, kRepeats), each = timing_of(series, kRepeats);
    std::string projection;
    for (size_t k = 0; k < kCounts; k++) {
        char text[64];
        std::snprintf(text, sizeof text, "%s\"%zu\": %.4f", k > 0 ? ", " : "", kPlanes[k],
                      timing_of(more[k], kRepeats).median * 1e3);
        projection += text;
    }
    const timing preprocess = time_of(50, [&] { network.preprocess().apply(frame, scratch, input.data()); });
    double moved = 0;
    for (size_t i = 0; !layout.max_pool && i < kFrames; i++) {
        const double latent = network.encode({&scene.frames[i * scene.pixels], side, side, side}, work);
        moved = std::max(moved, std::fabs(latent - scene.latents[i]) / scene.info.crb_px);
    }
    std::printf("{\"part\": \"encode\", \"isa\": \"%s\", \"layout\": \"%s\", \"ms\": %.4f, \"spread_ms\": %.2g, "
                "\"many_ms\": %.4f, \"preprocess_ms\": %.4f, \"projection_ms\": {%s}, "
                "\"roofline_ms\": %.4f, "
                "\"latent_moved_sigma\": %.3g}\n",
                toliman::kernels::host_isa_name(), layout.name, whole.median * 1e3, whole.spread * 1e3,
                each.median * 1e3, preprocess.median * 1e3, projection.c_str(), encoding_mflop(layout) / peak.sample(),
                moved);
}

void measure_training(const Layout &layout, Peak &peak) {
    Step step(layout);
    peak.sample();
    const timing time = time_of(1, [&] { step.batch(); });
    std::printf("{\"part\": \"training\", \"isa\": \"%s\", \"layout\": \"%s\", \"ms\": %.4f, \"spread_ms\": %.2g, "
                "\"batch\": %zu, \"roofline_ms\": %.4f}\n",
                toliman::kernels::host_isa_name(), layout.name, time.median * 1e3 / kBatch, time.spread * 1e3 / kBatch,
                kBatch, training_mflop(layout) / peak.sample());
}

// The least-squares estimate of the same frames.
void measure_template(const Scene &scene) {
    toliman_linear *linear = nullptr;
    check(toliman_linear_create(scene.sim, nullptr, &linear));
    double value = 0;
    const toliman_image image = scene.first_frames();
    const timing time = time_of(20, [&] { check(toliman_linear_encode(linear, &image, 1, &value, nullptr)); });
    std::printf("{\"part\": \"template\", \"ms\": %.4f, \"spread_ms\": %.2g}\n", time.median * 1e3, time.spread * 1e3);
    toliman_linear_destroy(linear);
}

void measure_tied(const Scene &scene) {
    toliman_cae *cae = nullptr;
    check(toliman_cae_create(scene.sim, 1, nullptr, &cae));
    toliman_cae_training report = {};
    report.struct_size = sizeof report;
    const auto start = std::chrono::steady_clock::now();
    check(toliman_cae_train(cae, nullptr, &report));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("{\"part\": \"tied\", \"seconds\": %.3f, \"steps\": %u, \"cosine\": %.5f}\n", seconds, report.steps,
                report.cosine);
    toliman_cae_destroy(cae);
}

} // namespace

int main(int count, char **arguments) {
    const Isa all[] = {Isa::avx512, Isa::avx2, Isa::baseline};
    chosen = *std::find_if(std::begin(all), std::end(all), runs);
    const Scene scene(kFlight), core(kCore);
    measure_tied(scene);
    measure_template(scene);
    for (const Isa isa : all) {
        if (!runs(isa))
            continue;
        chosen = isa;
        Peak peak = {isa};
        for (const Layout *layout : kLayouts) {
            if (count > 1)
                write_for_peers(arguments[1], *layout);
            measure_encode(layout->side == kCore.side ? core : scene, *layout, peak);
            measure_training(*layout, peak);
        }
        std::printf("{\"part\": \"peak\", \"isa\": \"%s\", \"gflops\": %.1f}\n", toliman::kernels::host_isa_name(),
                    peak.gflops);
        std::fflush(stdout);
    }
}
