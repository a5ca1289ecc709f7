// toliman encode: latents from frames.
#include <cstdio>
#include <utility>

#include "command.hpp"
#include "failure.hpp"
#include "frames_in.hpp"
#include "output.hpp"

namespace cli {

namespace {

struct EncodeOptions {
    std::string weights, dtype, shape;
    std::vector<std::string> files;
};

constexpr char kEncodeDescription[] = R"(Encode frames: one line a frame on stdout, file,frame,latent_px.

Examples:
  toliman encode --weights chapter.tlmw frames.npy night1.fits night2.fits.fz
  toliman encode --weights chapter.tlmw --dtype u32le --shape 256x256 frames.bin

Of a FITS file the first image is read: one frame or a cube, any BITPIX, compressed tiles included.)";

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
