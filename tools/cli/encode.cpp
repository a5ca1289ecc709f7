// toliman train, toliman encode: weights from a scene, latents from frames.
#include <cstdio>
#include <utility>

#include "command.hpp"
#include "failure.hpp"
#include "frames_in.hpp"
#include "output.hpp"
#include "scene.hpp"
#include "seed.hpp"

namespace cli {

namespace {

struct TrainOptions {
    std::string scene, out, payload = "float32";
    uint64_t seed = 1;
    uint32_t steps = 0;
};

struct EncodeOptions {
    std::string weights, dtype, shape;
    std::vector<std::string> files;
};

constexpr char kTrainDescription[] = R"(Train the autoencoder for a scene and write its weights.

Examples:
  toliman train examples/scenes/chapter.json --out chapter.tlmw
  toliman train examples/scenes/chapter.json --out small.tlmw --payload fp16

Frames must have 256x256 pixels or more. The weights hold all that `encode` needs: layout, preprocessing and reference
images. The cosine that is printed is the share of the photon limit that the encoder reaches.

--payload bf16 or fp16 stores all but the reference in half the bytes, rounded to 8 or 11 bits; lib/FORMATS.md has what
that costs.)";

constexpr char kEncodeDescription[] = R"(Encode frames: one line a frame on stdout, file,frame,latent_px.

Examples:
  toliman encode --weights chapter.tlmw frames.npy night1.fits night2.fits.fz
  toliman encode --weights chapter.tlmw --dtype u32le --shape 256x256 frames.bin

Of a FITS file the first image is read: one frame or a cube, any BITPIX, compressed tiles included.)";

toliman_cae_save_options encodings(const std::string &payload) {
    toliman_cae_save_options options;
    toliman_cae_save_options_init(&options);
    options.weights_encoding = payload == "bf16"   ? TOLIMAN_ENCODING_BF16
                               : payload == "fp16" ? TOLIMAN_ENCODING_FP16
                                                   : TOLIMAN_ENCODING_FLOAT32;
    options.planes_encoding = options.weights_encoding;
    return options;
}

void train(const TrainOptions &options, Progress &progress) {
    OutputFile out(options.out); // an unwritable place is found before the work, not after it
    const Scene scene(options.scene, progress);
    const auto cae = toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), options.seed);
    toliman_cae_train_options how;
    toliman_cae_train_options_init(&how);
    how.steps = options.steps;
    how.progress = Progress::callback;
    how.progress_data = &progress;
    toliman_cae_training report = {};
    report.struct_size = sizeof report;
    toliman::check(toliman_cae_train(cae.get(), &how, &report));
    const toliman_cae_save_options stored = encodings(options.payload);
    size_t size = 0;
    toliman::check(toliman_cae_save(cae.get(), &stored, nullptr, 0, &size));
    std::vector<unsigned char> blob(size);
    toliman::check(toliman_cae_save(cae.get(), &stored, blob.data(), size, &size));
    out.write(blob.data(), size);
    out.commit();
    progress.clear();
    std::fprintf(stderr, "%s: %u steps, loss %.4f, cosine %.4f, Cramer-Rao bound %.4g px\n", options.out.c_str(),
                 report.steps, report.loss, report.cosine, scene.info.crb_projected_px);
}

void shape_of(const std::string &text, size_t &rows, size_t &cols) {
    rows = cols = 0;
    if (text.empty())
        return;
    char rest = '\0';
    if (std::sscanf(text.c_str(), "%zux%zu%c", &rows, &cols, &rest) != 2 || rows == 0 || cols == 0 || rows > 65536 ||
        cols > 65536)
        throw Failure(kExitUsage, "--shape " + text + ": must be ROWSxCOLS, e.g. 256x256");
}

void encode(const EncodeOptions &options, Progress &progress) {
    const auto cae = toliman::make<toliman::autoencoder>(toliman_cae_load_file, options.weights.c_str());
    toliman_cae_info info = {};
    info.struct_size = sizeof info;
    toliman::check(toliman_cae_get_info(cae.get(), &info));
    size_t rows, cols;
    shape_of(options.shape, rows, cols);
    const char *head = "file,frame,latent_px\n"; // printed with the first line
    for (const std::string &path : options.files) {
        const auto file = open_frames(path, options.dtype, rows, cols);
        FrameFile &frames = *file;
        if (frames.rows() != static_cast<size_t>(info.rows) || frames.cols() != static_cast<size_t>(info.cols))
            throw Failure(kExitInput, path + ": frames of " + std::to_string(frames.rows()) + "x" +
                                          std::to_string(frames.cols()) + ", the weights take " +
                                          std::to_string(info.rows) + "x" + std::to_string(info.cols));
        std::vector<double> image(frames.rows() * frames.cols());
        for (size_t k = 0; k < frames.count(); k++) {
            frames.read(image.data());
            double latent;
            const toliman_status status = toliman_cae_encode(cae.get(), image.data(), frames.cols(), &latent);
            if (status != TOLIMAN_OK)
                throw Failure(kExitInput, path + ": frame " + std::to_string(k) + ": " + toliman_last_error());
            char line[64];
            std::snprintf(line, sizeof line, ",%zu,%.17g\n", k, latent);
            print_stdout(std::exchange(head, "") + path + line);
            progress.show("encode", static_cast<double>(k + 1) / static_cast<double>(frames.count()));
            stop_if_asked();
        }
    }
}

} // namespace

void add_train(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("train", kTrainDescription);
    auto options = std::make_shared<TrainOptions>();
    command->add_option("SCENE", options->scene, "scene file (JSON, schema toliman-scene/1)")->required();
    command->add_option("--out", options->out, "the weights file to write (.tlmw); - is standard output")->required();
    add_seed(*command, options->seed, "seed of the initial weights, default 1");
    command->add_option("--steps", options->steps, "Adam steps, default 600")->check(CLI::Range(1u, 1000000u));
    command->add_option("--payload", options->payload, "numbers of the file: float32 (default), bf16 or fp16")
        ->check(CLI::IsMember({"float32", "bf16", "fp16"}));
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            train(*options, progress);
        };
    });
}

void add_encode(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("encode", kEncodeDescription);
    auto options = std::make_shared<EncodeOptions>();
    command->add_option("--weights", options->weights, "weights file of `toliman train`")->required();
    command->add_option("--dtype", options->dtype, "of headerless files: u16le or u32le")
        ->check(CLI::IsMember({"u16le", "u32le"}));
    command->add_option("--shape", options->shape, "of headerless files: ROWSxCOLS");
    command->add_option("FRAMES", options->files, ".npy and FITS files, or headerless ones with --dtype and --shape")
        ->required();
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            encode(*options, progress);
        };
    });
}

} // namespace cli
