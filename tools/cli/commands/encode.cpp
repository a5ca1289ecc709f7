// toliman encode: latents from frames.
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/failure.hpp"
#include "common/output.hpp"
#include "frames/frames_in.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"

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
  toliman simulate chapter.json --out - | toliman encode --weights chapter.tlmw - | toliman period - --columns frame,latent_px
  receiver | toliman encode --weights chapter.tlmw --dtype u16le --shape 256x256 -

The column is called latent where it has no unit, after unsupervised training. The first frame that cannot be encoded, as
one with a NaN, ends the command; the lines before it are whole. The first latent above 1000 times the Cramer-Rao bound is
remarked upon: a frame 0.1 % brighter than the scene's is 6e-6 px off (chapter), one that is shifted far more, unless the
network was trained with preprocess.project.

Of a FITS file the first image is read: one frame or a cube, any BITPIX, compressed tiles included. On standard input (-)
comes .npy or, with --dtype and --shape, headerless frames until it ends; a line is printed as soon as its frame is there.)";

constexpr double kFarSigmas = 1000;

std::string text_of(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
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

// What the file holds as frames of the other width, which is a likely mistake where latents are far off.
std::string other_width(const EncodeOptions &options, const FrameFile &frames) {
    const bool wide = options.dtype == "u32le";
    if (options.dtype.empty() || !frames.counted() || (!wide && frames.count() % 2 != 0))
        return "";
    return " As --dtype " + std::string(wide ? "u16le" : "u32le") + " the file holds " +
           std::to_string(wide ? frames.count() * 2 : frames.count() / 2) + " frames, as " + options.dtype + " " +
           std::to_string(frames.count()) + ".";
}

void encode(const EncodeOptions &options, Progress &progress) {
    const Network network(options.weights);
    const toliman_cae_info &info = network.info;
    size_t rows, cols;
    shape_of(options.shape, rows, cols);
    const bool in_pixels = info.cosine > 0; // unsupervised training leaves the latent without a unit
    const char *head = in_pixels ? "file,frame,latent_px\n" : "file,frame,latent\n"; // printed with the first line
    bool far = false;
    for (const std::string &path : options.files) {
        const auto file = open_frames(path, options.dtype, rows, cols);
        FrameFile &frames = *file;
        if (frames.rows() != static_cast<size_t>(info.rows) || frames.cols() != static_cast<size_t>(info.cols))
            throw Failure(kExitInput, frames.path() + ": frames of " + std::to_string(frames.rows()) + "x" +
                                          std::to_string(frames.cols()) + ", the weights take " +
                                          std::to_string(info.rows) + "x" + std::to_string(info.cols));
        std::vector<double> image(frames.rows() * frames.cols());
        for (size_t k = 0; frames.more(); k++) {
            frames.read(image.data());
            double latent;
            const toliman_status status = toliman_cae_encode(network.cae.get(), image.data(), frames.cols(), &latent);
            if (status != TOLIMAN_OK)
                throw Failure(kExitInput, frames.path() + ": frame " + std::to_string(k) + ": " + toliman_last_error());
            if (in_pixels && !far && std::fabs(latent) > kFarSigmas * info.crb_px) {
                far = true;
                progress.warn(frames.path() + ": frame " + std::to_string(k) + ": a latent of " + text_of(latent) +
                              " px is far beyond the noise of " + text_of(info.crb_px) +
                              " px: is this frame of the network's scene, pointing and exposure?" +
                              other_width(options, frames));
            }
            char line[64];
            std::snprintf(line, sizeof line, ",%zu,%.17g\n", k, latent);
            print_stdout(std::exchange(head, "") + path + line);
            if (frames.counted())
                progress.show("encode", static_cast<double>(k + 1) / static_cast<double>(frames.count()));
            else
                progress.note("encode", std::to_string(k + 1) + " frames");
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
    command
        ->add_option("FRAMES", options->files,
                     ".npy and FITS files, or headerless ones with --dtype and --shape; - reads standard input")
        ->required();
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            encode(*options, progress);
        };
    });
}

} // namespace cli
