// toliman train: weights from a scene.
#include <exception>
#include <filesystem>
#include <tuple>

#include "frames/bank_training.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"
#include "run/training_log.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct TrainOptions {
    std::string scene, out, payload = "float32", mode = "tied", input = "whitened", centre = "scene", resume, log,
                            bad_pixels;
    std::string layout;              // "": by the size of the frames
    std::optional<std::string> bank; // its dates
    std::string free;                // further parameters of the fit of a bank
    bool resumes = false;            // with `resume` or, if that is empty, OUT.part
    uint64_t seed = 1;
    uint32_t steps = 0, epochs = 0, places = 0; // 0: the default
    double spacing = 0;                         // px; 0: the default
};

constexpr uint32_t kEpochs = 300;                       // the default
constexpr char kPart[] = ".part";                       // suffix of the weights of a stopped training
constexpr double kSameBound = 1e-9;                     // relative: rounding of another processor
constexpr uint64_t kTrainingNoise = 0x5452414900000000; // XORed with the seed of the weights: seed of the frames' noise

using Names = std::map<std::string, int32_t>;

const Names kModes = {{"tied", TOLIMAN_CAE_MODE_TIED}, {"unsupervised", TOLIMAN_CAE_MODE_UNSUPERVISED}};
const Names kLayouts = {
    {"flight", TOLIMAN_CAE_LAYOUT_FLIGHT}, {"paper", TOLIMAN_CAE_LAYOUT_PAPER}, {"core", TOLIMAN_CAE_LAYOUT_CORE}};
const Names kInputs = {
    {"whitened", TOLIMAN_CAE_INPUT_WHITENED}, {"residual", TOLIMAN_CAE_INPUT_RESIDUAL}, {"raw", TOLIMAN_CAE_INPUT_RAW}};
const Names kCentres = {{"scene", TOLIMAN_CAE_CENTRE_SCENE}, {"image", TOLIMAN_CAE_CENTRE_IMAGE}};
const Names kPayloads = {{"float32", TOLIMAN_CAE_ENCODING_FLOAT32},
                         {"bf16", TOLIMAN_CAE_ENCODING_BF16},
                         {"fp16", TOLIMAN_CAE_ENCODING_FP16}};

int32_t layout_of(const TrainOptions &options) {
    return options.layout.empty() ? 0 : kLayouts.at(options.layout);
}

// A network and how it is to be trained.
struct Training {
    toliman::autoencoder cae;
    toliman_cae_train_options how;
    uint64_t seed; // of the frames' noise too
};

Training new_training(const Scene &scene, const TrainOptions &options, Progress &progress) {
    const StopLimit limit;
    auto how = with_warnings<toliman_cae_options>(progress);
    how.layout = layout_of(options);
    how.input = kInputs.at(options.input);
    how.centre = kCentres.at(options.centre);
    Training training = {toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), options.seed, &how),
                         toliman::sized<toliman_cae_train_options>(), options.seed};
    training.how.mode = kModes.at(options.mode);
    training.how.steps = options.mode == "tied" ? options.steps : options.epochs;
    training.how.frame_count = static_cast<uint64_t>(scene.info.frames);
    return training;
}

// The interrupted training that a weights file contains; false if it contains none.
bool get_training(const toliman_cae *cae, toliman_cae_train_options &how) {
    how = toliman::sized<toliman_cae_train_options>();
    static_cast<void>(toliman::result<toliman_cae_info>(toliman_cae_get_info, cae, &how));
    return how.mode != 0;
}

// The word of a value.
std::string word_of(const Names &names, int32_t value) {
    return std::find_if(names.begin(), names.end(), [=](const auto &name) { return name.second == value; })->first;
}

// The same command with --resume: the options are those of the file.
void check_same(const std::string &file, const toliman_cae_info &info, const toliman_cae_train_options &how,
                const TrainOptions &options) {
    const bool tied = how.mode == TOLIMAN_CAE_MODE_TIED;
    const std::string layout = info.layout, seed = std::to_string(info.seed), steps = std::to_string(how.steps);
    for (const auto &[name, there, given] :
         {std::tuple("--mode", word_of(kModes, how.mode), options.mode),
          std::tuple("--layout", layout, options.layout.empty() ? layout : options.layout),
          std::tuple("--input", word_of(kInputs, info.input), options.input),
          std::tuple("--centre", word_of(kCentres, info.centre), options.centre),
          std::tuple("--seed", seed, std::to_string(options.seed)),
          std::tuple("--steps", steps, tied && options.steps != 0 ? std::to_string(options.steps) : steps)})
        if (there != given)
            throw Failure(kExitUsage, file + ": was trained with " + name + " " + there +
                                          ": give the same; without --resume it is replaced");
}

Training resumed_training(const Scene &scene, const TrainOptions &options, const std::string &file) {
    toliman::autoencoder cae = load_weights(file);
    const auto info = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae.get(), nullptr);
    if (info.scene_digest != scene.info.scene_digest)
        throw Failure(kExitUsage, file + ": was trained for another scene, not " + scene.path +
                                      ": give the scene of the first training");
    const double bound = scene.bounds().crb_projected_px; // depends on all files of the scene
    if (!(std::fabs(bound - info.crb_px) <= kSameBound * bound))
        throw Failure(kExitUsage, file + ": was trained before a file that " + scene.path +
                                      " names changed: give the files of the first training");
    Training training = {std::move(cae), {}, info.seed};
    if (!get_training(training.cae.get(), training.how))
        throw Failure(kExitUsage, file + ": contains no training to resume");
    if (options.resume.empty())
        check_same(file, info, training.how, options);
    if (training.how.mode == TOLIMAN_CAE_MODE_TIED)
        return training;
    const uint32_t epochs = options.epochs != 0 ? options.epochs : kEpochs;
    if (training.how.steps > epochs)
        throw Failure(kExitUsage, "--epochs " + std::to_string(epochs) + ": must be at least " +
                                      std::to_string(training.how.steps) + ", the epochs done in " + file);
    training.how.steps = epochs;
    return training;
}

// The file of the training to resume, "" to begin.
std::string to_resume(const TrainOptions &options) {
    const std::string part = options.out + kPart;
    return !options.resume.empty() ? options.resume : options.resumes && exists(part) ? part : "";
}

// TrainOptions for banks are refused without one, and those for networks with one.
void check_bank_options(const TrainOptions &options) {
    const bool has_bank = options.bank.has_value();
    const char *const of_bank = ": is for a bank of networks: needs --bank";
    const char *const of_network = ": the networks of a bank have tied training on whitened residuals";
    refuse_mistakes(
        {{!has_bank && options.places != 0, std::string("--places") + of_bank},
         {!has_bank && options.spacing != 0, std::string("--spacing") + of_bank},
         {!has_bank && !options.free.empty(), std::string("--free") + of_bank},
         {has_bank && !options.log.empty(), "--log: is for unsupervised training"},
         {has_bank && options.centre != "scene", "--centre image: the networks of a bank follow the fitted stars"},
         {has_bank && options.mode != "tied", std::string("--mode") + of_network},
         {has_bank && options.input != "whitened", std::string("--input") + of_network},
         {has_bank && options.epochs != 0, std::string("--epochs") + of_network}});
}

// Epochs of the training that a network resumes.
uint32_t done_in(const toliman_cae *cae) {
    toliman_cae_train_options how = {};
    return get_training(cae, how) ? how.steps : 0;
}

// An option of the other mode is refused.
void check_mode(const TrainOptions &options, bool tied) {
    const std::string unsupervised = ": needs --mode unsupervised";
    refuse_mistakes({{tied && !options.log.empty(), "--log: is for unsupervised training"},
                     {tied && options.epochs != 0, "--epochs: is for unsupervised training; tied training has --steps"},
                     {!tied && options.steps != 0, "--steps: is for tied training; unsupervised training has --epochs"},
                     {tied && options.layout == "paper", "--layout paper" + unsupervised},
                     {tied && options.input != "whitened", "--input " + options.input + unsupervised}});
}

struct Frames {
    const Scene &scene;
    uint64_t seed;
    // Called for many frames only before the first epoch, when there is no training to save.
    static toliman_status give(size_t first, size_t count, double *counts, void *user_data) {
        const StopLimit limit;
        const auto &frames = *static_cast<const Frames *>(user_data);
        return toliman_sim_frame(frames.scene.sim.get(), nullptr, frames.seed, static_cast<int64_t>(first), count,
                                 counts);
    }
};

using Bytes = std::vector<unsigned char>;

Bytes bytes_of_network(const toliman_cae *cae, const std::string &payload, bool with_training) {
    auto how = toliman::sized<toliman_cae_save_options>();
    how.weights_encoding = how.planes_encoding = kPayloads.at(payload);
    how.with_training = with_training ? 1 : 0;
    return bytes_of([&](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_cae_save(cae, &how, data, capacity, size);
    });
}

void write(const Bytes &bytes, OutputFile &out) {
    out.write(bytes);
    out.commit();
}

void report_result(const TrainOptions &options, const Scene &scene, bool tied, const toliman_cae_training &result) {
    if (tied)
        std::fprintf(stderr, "%s: %u steps, loss %.4f, cosine %.4f, Cramer-Rao bound %.4g px\n", options.out.c_str(),
                     result.steps, result.loss, result.cosine, scene.bounds().crb_projected_px);
    else
        std::fprintf(stderr, "%s: %u epochs, loss %.4g, validation %.4g, MMSE %.4g (noise alone %.4g), MSSIM %.6f\n",
                     options.out.c_str(), result.epochs, result.loss, result.validation_loss, result.mmse,
                     result.photon_floor, result.mssim);
}

// A stopped training goes to OUT.part: --out may already contain a complete network, which must not be lost. A FILE of
// --resume implies options of its training, which the same command without it would lack.
void save_interrupted(const Bytes &bytes, const TrainOptions &options, Progress &progress) {
    const std::string part = options.out + kPart;
    OutputFile out(part);
    write(bytes, out);
    progress.tell("the same command with --resume " + (options.resume.empty() ? "" : part + " ") + "continues from " +
                  part);
}

// After each epoch: its line in the log and, with the false alarm probabilities, OUT.part, so that a power cut costs at
// most ten epochs.
struct Epochs {
    TrainingLog log;
    std::string part;           // OUT.part; "" if there is none
    uint32_t last;              // epoch
    std::exception_ptr failure; // of a write

    static int32_t note(const toliman_cae *so_far, const toliman_cae_training *result, void *user_data) noexcept {
        auto &epochs = *static_cast<Epochs *>(user_data);
        try {
            const bool searched = epochs.log.add(so_far, *result, result->epochs == epochs.last);
            if (searched && !epochs.part.empty()) {
                OutputFile out(epochs.part);
                write(bytes_of_network(so_far, "float32", true), out);
            }
            return 0;
        } catch (...) {
            epochs.failure = std::current_exception();
            return 1;
        }
    }
};

void train_network(const TrainOptions &options, OutputFile &out, Progress &progress) {
    const Scene scene(options.scene, progress, options.bad_pixels);
    const std::string resume = to_resume(options);
    auto [cae, how, seed] =
        resume.empty() ? new_training(scene, options, progress) : resumed_training(scene, options, resume);
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
    std::optional<Epochs> epochs;
    if (!options.log.empty()) {
        epochs.emplace(Epochs{{options.log, scene, frames.seed, resume.empty() ? 0 : done_in(cae.get())},
                              options.out != "-" ? options.out + kPart : "",
                              how.steps != 0 ? how.steps : kEpochs,
                              nullptr});
        if (resume.empty())
            epochs->log.add_untrained(cae.get());
        how.epoch = Epochs::note;
        how.epoch_data = &*epochs;
    }
    auto result = toliman::sized<toliman_cae_training>();
    const toliman_status status = toliman_cae_train(cae.get(), &how, &result);
    progress.clear();
    if (status == TOLIMAN_E_CANCELLED) {
        if (get_training(cae.get(), how) && options.out != "-")
            save_interrupted(bytes_of_network(cae.get(), "float32", true), options, progress);
        stop_if_asked();
        if (epochs && epochs->failure)
            std::rethrow_exception(epochs->failure);
    }
    toliman::check(status);
    write(bytes_of_network(cae.get(), options.payload, !tied && options.payload == "float32"), out);
    if (options.out != "-")
        std::filesystem::remove(options.out + kPart);
    report_result(options, scene, tied, result);
}

BankRequest bank_request(const TrainOptions &options) {
    BankRequest request = {options.scene,
                           options.free,
                           options.bad_pixels,
                           *options.bank,
                           options.out,
                           options.out != "-" ? options.out + kPart : "",
                           options.resumes,
                           kPayloads.at(options.payload),
                           toliman::sized<toliman_bank_options>()};
    request.options.layout = layout_of(options);
    request.options.spacing_px = options.spacing;
    request.options.places = options.places;
    request.options.steps = options.steps;
    request.options.seed = options.seed;
    return request;
}

void train(const TrainOptions &options, Progress &progress) {
    check_not_input(options.out, {options.scene});
    OutputFile out(options.out); // before the training: an unwritable path fails at once
    if (options.out != "-")
        check_output(options.out + kPart);
    check_bank_options(options);
    if (options.bank)
        train_bank(bank_request(options), out, progress);
    else
        train_network(options, out, progress);
}

} // namespace

void add_train(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "train");
    auto options = std::make_shared<TrainOptions>();
    add_scene(*command, options->scene);
    add_bad_pixels(*command, options->bad_pixels);
    add_option(command, "--out", options->out, "FILE")->required();
    CLI::Option *resume = add_option(command, "--resume", options->resume, "[FILE]")->expected(0, 1);
    add_seed(*command, options->seed);
    add_choice(command, "--mode", options->mode, kModes);
    add_choice(command, "--layout", options->layout, kLayouts);
    add_choice(command, "--input", options->input, kInputs);
    add_choice(command, "--centre", options->centre, kCentres);
    command->add_option("--steps", options->steps)->check(CLI::Range(1u, 1000000u));
    add_option(command, "--bank", options->bank, "DATE:DATE");
    command->add_option("--places", options->places)->check(CLI::Range(1u, 8u));
    command->add_option("--spacing", options->spacing)->check(CLI::Range(0.05, 4.0));
    add_option(command, "--free", options->free, "NAMES");
    command->add_option("--epochs", options->epochs)->check(CLI::Range(1u, 1000000u));
    add_option(command, "--log", options->log, "FILE");
    add_choice(command, "--payload", options->payload, kPayloads);
    set_action(*command, context, options, train, [command, options, resume] {
        options->resumes = resume->count() > 0;
        for (const char *name :
             {"--seed", "--mode", "--layout", "--input", "--centre", "--steps", "--bank", "--places", "--spacing"})
            if (!options->resume.empty() && command->get_option(name)->count() > 0)
                throw CLI::ExcludesError("--resume", name); // those of the file
    });
}

} // namespace cli
