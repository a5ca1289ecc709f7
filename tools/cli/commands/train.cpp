// toliman train: weights from a scene.
#include <cstdio>
#include <map>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out, payload = "float32", mode = "tied", layout = "flight", input = "whitened", resume;
    uint64_t seed = 1;
    uint32_t steps = 0, epochs = 0; // 0: the default
};

constexpr uint32_t kEpochs = 300;                       // the default
constexpr char kPart[] = ".part";                       // suffix of the weights of a stopped training
constexpr uint64_t kTrainingNoise = 0x5452414900000000; // XORed with the seed of the weights: seed of the frames' noise

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

Training new_training(const Scene &scene, const Options &options, Progress &progress) {
    const StopLimit limit;
    auto how = with_warnings<toliman_cae_options>(progress);
    how.layout = kLayouts.at(options.layout);
    how.input = kInputs.at(options.input);
    Training training = {toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), options.seed, &how),
                         toliman::sized<toliman_cae_train_options>(), options.seed};
    training.how.mode = kModes.at(options.mode);
    training.how.steps = options.steps;
    training.how.epochs = options.epochs;
    training.how.frame_count = static_cast<uint64_t>(scene.info.frames);
    return training;
}

// The interrupted training that a weights file contains; false if it contains none.
bool get_training(const toliman_cae *cae, toliman_cae_train_options &how) {
    how = toliman::sized<toliman_cae_train_options>();
    return toliman_cae_get_train_options(cae, &how) == TOLIMAN_OK;
}

Training resumed_training(const Scene &scene, const Options &options) {
    toliman::autoencoder cae = load_weights(options.resume);
    const auto info = info_from<toliman_cae_info>(toliman_cae_get_info, cae.get());
    if (info.scene_digest != scene.info.scene_digest)
        throw Failure(kExitUsage, options.resume + ": was trained for another scene, not " + scene.path +
                                      ": give the scene of the first training");
    Training training = {std::move(cae), {}, info.seed};
    if (!get_training(training.cae.get(), training.how))
        throw Failure(kExitUsage, options.resume + ": contains no training to resume");
    const uint32_t epochs = options.epochs != 0 ? options.epochs : kEpochs;
    if (training.how.epochs > epochs)
        throw Failure(kExitUsage, "--epochs " + std::to_string(epochs) + ": must be at least " +
                                      std::to_string(training.how.epochs) + ", the epochs done in " + options.resume);
    training.how.epochs = epochs;
    return training;
}

// An option that does not belong to the mode is refused.
void check_mode(const Options &options, bool tied) {
    if (tied && options.epochs != 0)
        throw Failure(kExitUsage, "--epochs: is for unsupervised training; tied training has --steps");
    if (!tied && options.steps != 0)
        throw Failure(kExitUsage, "--steps: is for tied training; unsupervised training has --epochs");
    if (tied && (options.layout != "flight" || options.input != "whitened"))
        throw Failure(kExitUsage, "--layout " + options.layout + ", --input " + options.input +
                                      ": tied training needs flight and whitened; the others need --mode unsupervised");
}

struct Frames {
    const Scene &scene;
    uint64_t seed;
    // Called for many frames only before the first epoch, when there is no training to save.
    static toliman_status give(size_t first, size_t count, double *counts, void *user_data) {
        const StopLimit limit;
        const auto &frames = *static_cast<const Frames *>(user_data);
        return toliman_sim_frame_many(frames.scene.sim.get(), nullptr, frames.seed, static_cast<int64_t>(first), count,
                                      0, counts);
    }
};

void write(const toliman::autoencoder &cae, const std::string &payload, bool with_training, OutputFile &out) {
    auto how = toliman::sized<toliman_cae_save_options>();
    how.weights_encoding = how.planes_encoding = kPayloads.at(payload);
    how.training = with_training ? 1 : 0;
    out.write(bytes_of([&](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_cae_save(cae.get(), &how, data, capacity, size);
    }));
    out.commit();
}

void report_result(const Options &options, const Scene &scene, bool tied, const toliman_cae_training &result) {
    if (tied)
        std::fprintf(stderr, "%s: %u steps, loss %.4f, cosine %.4f, Cramer-Rao bound %.4g px\n", options.out.c_str(),
                     result.steps, result.loss, result.cosine, scene.bounds().crb_projected_px);
    else
        std::fprintf(stderr, "%s: %u epochs, loss %.4g, validation %.4g, MMSE %.4g (noise alone %.4g), MSSIM %.6f\n",
                     options.out.c_str(), result.epochs, result.loss, result.validation_loss, result.mmse,
                     result.photon_floor, result.mssim);
}

// A stopped training goes to OUT.part: --out may already contain a complete network, which must not be lost.
void save_interrupted(const toliman::autoencoder &cae, const Options &options) {
    const std::string part = options.out + kPart;
    OutputFile out(part);
    write(cae, "float32", true, out);
    const std::string epochs = options.epochs != 0 ? " --epochs " + std::to_string(options.epochs) : "";
    std::fprintf(stderr, "toliman: resume with: toliman train %s --resume %s --out %s%s\n", options.scene.c_str(),
                 part.c_str(), options.out.c_str(), epochs.c_str());
}

void train(const Options &options, Progress &progress) {
    check_not_input(options.out, {options.scene});
    OutputFile out(options.out); // before the training: an unwritable path fails at once
    if (options.out != "-")
        check_output(options.out + kPart);
    const Scene scene(options.scene, progress);
    auto [cae, how, seed] =
        options.resume.empty() ? new_training(scene, options, progress) : resumed_training(scene, options);
    const bool tied = how.mode == TOLIMAN_CAE_MODE_TIED;
    check_mode(options, tied);
    if (!tied && scene.info.frames < 2)
        throw Failure(kExitUsage, scene.path + ": cadence.frames = " + std::to_string(scene.info.frames) +
                                      ": unsupervised training needs at least 2");
    // Other noise than that of `simulate` with the same seed, so that the network has not seen the frames it will
    // encode.
    Frames frames = {scene, seed ^ kTrainingNoise};
    how.frames = Frames::give;
    how.frames_data = &frames;
    how.progress = Progress::callback;
    how.progress_data = &progress;
    auto result = toliman::sized<toliman_cae_training>();
    const toliman_status status = toliman_cae_train(cae.get(), &how, &result);
    progress.clear();
    if (status == TOLIMAN_E_CANCELLED) {
        if (get_training(cae.get(), how) && options.out != "-")
            save_interrupted(cae, options);
        stop_if_asked();
    }
    toliman::check(status);
    write(cae, options.payload, !tied && options.payload == "float32", out);
    report_result(options, scene, tied, result);
}

} // namespace

void add_train(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "train");
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "FILE", "weights file to write (.tlmw); - writes to standard output")
        ->required();
    CLI::Option *resume =
        add_option(command, "--resume", options->resume, "FILE", "weights file with a training to continue");
    add_seed(*command, options->seed, "seed of the initial weights and of the frames' noise, default 1");
    add_choice(command, "--mode", options->mode, kModes, "training: tied (default) or unsupervised");
    add_choice(command, "--layout", options->layout, kLayouts,
               "network: flight (default), or paper, the book chapter's; paper needs --mode unsupervised");
    add_choice(command, "--input", options->input, kInputs,
               "preprocessing of frames: whitened (default), residual or raw; the last two need --mode unsupervised");
    command->add_option("--steps", options->steps, "number of steps of tied training, default 300")
        ->check(CLI::Range(1u, 1000000u));
    for (const char *name : {"--seed", "--mode", "--layout", "--input", "--steps"})
        resume->excludes(command->get_option(name)); // those of the file
    command
        ->add_option("--epochs", options->epochs,
                     "number of epochs of unsupervised training, including those before --resume, default 300")
        ->check(CLI::Range(1u, 1000000u));
    add_choice(command, "--payload", options->payload, kPayloads,
               "number format of the file: float32 (default), bf16 or fp16");
    set_action(*command, context, options, train);
}

} // namespace cli
