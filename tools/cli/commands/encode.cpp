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

constexpr char kEncodeDescription[] = R"(Encode frames: one line per frame on stdout, file,frame,latent_px,chi_square.

Examples:
  toliman encode --weights chapter.tlmw frames.npy night1.fits night2.fits.fz
  toliman encode --weights chapter.tlmw --dtype u32le --shape 256x256 frames.bin
  toliman simulate chapter.json --out - | toliman encode --weights chapter.tlmw - | toliman period - --columns frame,latent_px
  receiver | toliman encode --weights chapter.tlmw --dtype u16be --shape 256x256 -

The column is called latent where it has no unit, after unsupervised training. The column chi_square is what the scene
leaves of a frame, per degree of freedom: 1 +- 0.0055 for frames of the scene (1 sigma), other values for damaged ones and
for systematics that the network was not trained against. The first frame that cannot be encoded, as one with a NaN, ends
the command; the lines before it are whole. A warning names the first frame whose latent is above 1000 times the
Cramer-Rao bound or whose chi_square is more than 5 sigma from 1: a frame 0.1 % brighter than the scene's is 6e-6 px off
(chapter), one that is shifted far more, unless the network was trained with preprocess.project.

Of a FITS file the first image is read: one frame or a cube, any BITPIX, compressed tiles included. On standard input (-)
comes .npy or, with --dtype and --shape, headerless frames until it ends; a line is printed as soon as its frame is there.)";

constexpr double kFarSigmas = 1000;
constexpr double kChiSquareSigma = 0.00552; // sqrt(2/65536)
constexpr double kFarChiSquare = 5 * kChiSquareSigma;

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
    const bool wide = options.dtype.substr(0, 3) == "u32";
    if (options.dtype.empty() || options.dtype[0] != 'u' || !frames.counted() || (!wide && frames.count() % 2 != 0))
        return "";
    return " As --dtype " + std::string(wide ? "u16" : "u32") + options.dtype.substr(3) + " the file holds " +
           std::to_string(wide ? frames.count() * 2 : frames.count() / 2) + " frames, as " + options.dtype + " " +
           std::to_string(frames.count()) + ".";
}

void encode_frame(const Network &network, const std::vector<double> &pixels, const FrameFile &frames, size_t k,
                  double &latent, double &chi_square) {
    const toliman_image image = plain_image(pixels.data());
    if (toliman_cae_encode_many(network.cae.get(), &image, 1, 1, &latent, &chi_square) == TOLIMAN_OK)
        return;
    const toliman_status status = // again, for a message that does not count frames
        toliman_cae_encode(network.cae.get(), pixels.data(), frames.cols(), &latent);
    throw Failure(kExitInput, frames.path() + ": frame " + std::to_string(k) + ": " +
                                  (status != TOLIMAN_OK ? toliman_last_error() : "out of memory"));
}

// What is wrong with a frame of the network's scene, "" if nothing; of a latent without a unit only its chi-square
// tells.
std::string complaint_of(double latent, double chi_square, const toliman_cae_info &info) {
    if (info.cosine > 0 && std::fabs(latent) > kFarSigmas * info.crb_px)
        return "a latent of " + text_of(latent) + " px is far beyond the noise of " + text_of(info.crb_px) + " px";
    if (!(std::fabs(chi_square - 1) <= kFarChiSquare))
        return "a chi-square of " + text_of(chi_square) + " is not the 1 +- " + text_of(kChiSquareSigma) +
               " of the scene's noise";
    return "";
}

void encode(const EncodeOptions &options, Progress &progress) {
    const Network network(options.weights);
    const toliman_cae_info &info = network.info;
    size_t rows, cols;
    shape_of(options.shape, rows, cols);
    const bool in_pixels = info.cosine > 0; // unsupervised training leaves the latent without a unit
    // Printed with the first line.
    const char *head = in_pixels ? "file,frame,latent_px,chi_square\n" : "file,frame,latent,chi_square\n";
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
            double latent, chi_square;
            encode_frame(network, image, frames, k, latent, chi_square);
            const std::string complaint = far ? "" : complaint_of(latent, chi_square, info);
            if (!complaint.empty()) {
                far = true;
                progress.warn(frames.path() + ": frame " + std::to_string(k) + ": " + complaint +
                              ": is this frame of the network's scene, pointing and exposure?" +
                              other_width(options, frames));
            }
            char line[96];
            std::snprintf(line, sizeof line, ",%zu,%.17g,%.6g\n", k, latent, chi_square);
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
    command
        ->add_option("--dtype", options->dtype,
                     "of headerless files: u16le, u32le, i16le, f32le, or big-endian u16be, u32be, i16be, f32be")
        ->check(CLI::IsMember(dtypes()));
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
