// toliman train: weights from a scene.
#include <cstdio>
#include <map>

#include "common/failure.hpp"
#include "common/output.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"
#include "options/seed.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out, payload = "float32", mode = "tied", layout = "flight", input = "whitened", resume;
    uint64_t seed = 1;
    uint32_t steps = 0, epochs = 0; // 0: the default
};

constexpr uint32_t kEpochs = 300;                       // the default
constexpr uint64_t kTrainingNoise = 0x5452414900000000; // turns the seed of weights into that of frames

constexpr char kDescription[] = R"(Train the autoencoder for a scene and write its weights.

Examples:
  toliman train chapter.json --out chapter.tlmw
  toliman train chapter.json --out small.tlmw --payload fp16
  toliman train big.json --mode unsupervised --layout paper --input raw --epochs 300 --out paper.tlmw
  toliman train big.json --resume paper.tlmw --epochs 600 --out paper.tlmw

Frames must have 256x256 pixels or more. The weights hold all that `encode` needs: layout, preprocessing and reference
images. Tied training needs no frames; the cosine that is printed is the share of the photon limit that the encoder
reaches. Unsupervised training, the chapter's, learns to give the scene's own noisy frames back, a tenth of them kept
for validation; its latent has no unit, and signals below about 1e-4 px are beyond it.

A training stopped by a signal after its first step or epoch leaves what it has learnt in OUT.part, beside what --out
held, and goes on with --resume to the same result; so does a finished unsupervised one with more --epochs. Mode, steps
and seed are then those of the file. Unsupervised training takes 7 ms of processor time a frame and epoch (`paper`; `flight`
2.5 ms) and 256 KiB of memory a frame; the noise of its frames is of another seed than `simulate` would take.

--payload bf16 or fp16 stores all but the reference in half the bytes, rounded to 8 or 11 bits; formats.md has what
that costs. A training can only be taken up from float32, in which a stopped one is always written.)";

using Names = std::map<std::string, int32_t>;

const Names kModes = {{"tied", TOLIMAN_CAE_MODE_TIED}, {"unsupervised", TOLIMAN_CAE_MODE_UNSUPERVISED}};
const Names kLayouts = {{"flight", TOLIMAN_CAE_LAYOUT_FLIGHT}, {"paper", TOLIMAN_CAE_LAYOUT_PAPER}};
const Names kInputs = {
    {"whitened", TOLIMAN_CAE_INPUT_WHITENED}, {"residual", TOLIMAN_CAE_INPUT_RESIDUAL}, {"raw", TOLIMAN_CAE_INPUT_RAW}};
const Names kPayloads = {{"float32", TOLIMAN_CAE_ENCODING_FLOAT32},
                         {"bf16", TOLIMAN_CAE_ENCODING_BF16},
                         {"fp16", TOLIMAN_CAE_ENCODING_FP16}};

// A network and how it is to be trained.
struct Training {
    toliman::autoencoder cae;
    toliman_cae_train_options how;
    uint64_t seed; // of the frames' noise too
};

Training new_training(const Scene &scene, const Options &options) {
    toliman_cae_options how;
    toliman_cae_options_init(&how, sizeof how);
    how.layout = kLayouts.at(options.layout);
    how.input = kInputs.at(options.input);
    Training training = {
        toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), options.seed, &how), {}, options.seed};
    toliman_cae_train_options_init(&training.how, sizeof training.how);
    training.how.mode = kModes.at(options.mode);
    training.how.steps = options.steps;
    training.how.epochs = options.epochs;
    training.how.frame_count = static_cast<uint64_t>(scene.info.frames);
    return training;
}

// The training that a network can go on with, if there is one.
bool get_how(const toliman_cae *cae, toliman_cae_train_options &how) {
    toliman_cae_train_options_init(&how, sizeof how);
    return toliman_cae_get_train_options(cae, &how) == TOLIMAN_OK;
}

Training resumed_training(const Scene &scene, const Options &options) {
    toliman::autoencoder cae = load_weights(options.resume);
    toliman_cae_info info = {};
    info.struct_size = sizeof info;
    toliman::check(toliman_cae_get_info(cae.get(), &info));
    if (info.scene_digest != scene.info.scene_digest)
        throw Failure(kExitUsage, options.resume + ": was trained for another scene than " + scene.path +
                                      ": give the scene that it was begun with");
    Training training = {std::move(cae), {}, info.seed};
    if (!get_how(training.cae.get(), training.how))
        throw Failure(kExitUsage, options.resume + ": holds no training to go on with");
    const uint32_t epochs = options.epochs != 0 ? options.epochs : kEpochs;
    if (training.how.epochs > epochs)
        throw Failure(kExitUsage, options.resume + ": has seen " + std::to_string(training.how.epochs) +
                                      " epochs: --epochs must be at least that, not " + std::to_string(epochs));
    training.how.epochs = epochs;
    return training;
}

// An option that the mode has no use for is a mistake.
void check_mode(const Options &options, bool tied) {
    if (tied && options.epochs != 0)
        throw Failure(kExitUsage, "--epochs: of unsupervised training; tied training takes --steps");
    if (!tied && options.steps != 0)
        throw Failure(kExitUsage, "--steps: of tied training; unsupervised training takes --epochs");
    if (tied && (options.layout != "flight" || options.input != "whitened"))
        throw Failure(kExitUsage, "--layout " + options.layout + ", --input " + options.input +
                                      ": tied training takes flight and whitened; the others need --mode unsupervised");
}

struct Frames {
    const Scene &scene;
    uint64_t seed;
    static toliman_status give(size_t first, size_t count, double *counts, void *user_data) {
        const auto &frames = *static_cast<const Frames *>(user_data);
        return toliman_sim_frame_many(frames.scene.sim.get(), nullptr, frames.seed, static_cast<int64_t>(first), count,
                                      0, counts);
    }
};

void write(const toliman::autoencoder &cae, const std::string &payload, bool with_training, OutputFile &out) {
    toliman_cae_save_options how;
    toliman_cae_save_options_init(&how, sizeof how);
    how.weights_encoding = how.planes_encoding = kPayloads.at(payload);
    how.training = with_training ? 1 : 0;
    size_t size = 0;
    toliman::check(toliman_cae_save(cae.get(), &how, nullptr, 0, &size));
    std::vector<unsigned char> blob(size);
    toliman::check(toliman_cae_save(cae.get(), &how, blob.data(), size, &size));
    out.write(blob.data(), size);
    out.commit();
}

void report_result(const Options &options, const Scene &scene, bool tied, const toliman_cae_training &result) {
    if (tied)
        std::fprintf(stderr, "%s: %u steps, loss %.4f, cosine %.4f, Cramer-Rao bound %.4g px\n", options.out.c_str(),
                     result.steps, result.loss, result.cosine, scene.info.crb_projected_px);
    else
        std::fprintf(stderr, "%s: %u epochs, loss %.4g, validation %.4g, MMSE %.4g (noise alone %.4g), MSSIM %.6f\n",
                     options.out.c_str(), result.epochs, result.loss, result.validation_loss, result.mmse,
                     result.photon_floor, result.mssim);
}

std::string part_of(const std::string &out) {
    return out + ".part";
}

// Weights that --out may hold already are worth more than half a training.
void keep_part(const toliman::autoencoder &cae, const Options &options) {
    const std::string part = part_of(options.out);
    OutputFile out(part);
    write(cae, "float32", true, out);
    std::fprintf(stderr, "toliman: go on with: toliman train %s --resume %s --out %s%s\n", options.scene.c_str(),
                 part.c_str(), options.out.c_str(),
                 options.epochs != 0 ? (" --epochs " + std::to_string(options.epochs)).c_str() : "");
}

void train(const Options &options, Progress &progress) {
    check_apart(options.out, {options.scene});
    OutputFile out(options.out); // an unwritable place is found before the work, not after it
    if (options.out != "-")
        check_output(part_of(options.out));
    const Scene scene(options.scene, progress);
    auto [cae, how, seed] = options.resume.empty() ? new_training(scene, options) : resumed_training(scene, options);
    const bool tied = how.mode == TOLIMAN_CAE_MODE_TIED;
    check_mode(options, tied);
    if (!tied && scene.info.frames < 2)
        throw Failure(kExitUsage, scene.path + ": cadence.frames = " + std::to_string(scene.info.frames) +
                                      ": unsupervised training takes at least 2");
    // Other noise than that of `simulate` with the same seed: a network would know those frames.
    Frames frames = {scene, seed ^ kTrainingNoise};
    how.frames = Frames::give;
    how.frames_data = &frames;
    how.progress = Progress::callback;
    how.progress_data = &progress;
    toliman_cae_training result = {};
    result.struct_size = sizeof result;
    const toliman_status status = toliman_cae_train(cae.get(), &how, &result);
    progress.clear();
    if (status == TOLIMAN_E_CANCELLED) {
        if (get_how(cae.get(), how) && options.out != "-")
            keep_part(cae, options);
        stop_if_asked();
    }
    toliman::check(status);
    write(cae, options.payload, !tied && options.payload == "float32", out);
    report_result(options, scene, tied, result);
}

} // namespace

void add_train(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("train", kDescription);
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    command->add_option("--out", options->out, "the weights file to write (.tlmw); - is standard output")->required();
    CLI::Option *resume =
        command->add_option("--resume", options->resume, "go on with the training in this weights file");
    resume->excludes(add_seed(*command, options->seed, "seed of the initial weights and the frames' noise, default 1"));
    resume->excludes(
        command->add_option("--mode", options->mode, "tied (default) or unsupervised")->check(CLI::IsMember(kModes)));
    resume->excludes(
        command->add_option("--layout", options->layout, "flight (default) or paper; paper only unsupervised")
            ->check(CLI::IsMember(kLayouts)));
    resume->excludes(
        command
            ->add_option("--input", options->input, "whitened (default), residual or raw; the others only unsupervised")
            ->check(CLI::IsMember(kInputs)));
    resume->excludes(command->add_option("--steps", options->steps, "of tied training, default 300")
                         ->check(CLI::Range(1u, 1000000u)));
    command->add_option("--epochs", options->epochs, "of unsupervised training, in all, default 300")
        ->check(CLI::Range(1u, 1000000u));
    command->add_option("--payload", options->payload, "numbers of the file: float32 (default), bf16 or fp16")
        ->check(CLI::IsMember(kPayloads));
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            train(*options, progress);
        };
    });
}

} // namespace cli
