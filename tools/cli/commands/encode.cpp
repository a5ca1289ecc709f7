// toliman encode: latents from frames.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/text.hpp"
#include "frames/frames_in.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct EncodeOptions {
    std::string weights, dtype, shape;
    std::vector<std::string> files;
};

constexpr double kFarSigmas = 1000;
constexpr double kChiSquareSigma = 0.00552; // sqrt(2/65536)
constexpr double kFarChiSquare = 5 * kChiSquareSigma;

void shape_of(const std::string &text, int64_t &rows, int64_t &cols) {
    rows = cols = 0;
    if (!text.empty() &&
        (!two_numbers(text, 'x', rows, cols) || std::min(rows, cols) < 1 || std::max(rows, cols) > 65536))
        throw Failure(kExitUsage, "--shape " + text + ": must be ROWSxCOLS, e.g. 256x256");
}

// The number of frames in the file if its pixels had the other width: a likely mistake where latents are far off.
std::string other_width(const EncodeOptions &options, const FrameFile &frames) {
    const bool wide = options.dtype.substr(0, 3) == "u32";
    if (options.dtype.empty() || options.dtype[0] != 'u' || !frames.counted() || (!wide && frames.count() % 2 != 0))
        return "";
    return " With --dtype " + std::string(wide ? "u16" : "u32") + options.dtype.substr(3) + " the file has " +
           std::to_string(wide ? frames.count() * 2 : frames.count() / 2) + " frames, with " + options.dtype + " " +
           std::to_string(frames.count()) + ".";
}

void encode_next(const Network &network, FrameFile &frames, void *pixels, const std::string &place, double &latent,
                 double &chi_square) {
    auto image = toliman::sized<toliman_image>();
    image.pixel = frames.pixel();
    image.pixels = pixels;
    frames.read(pixels);
    if (toliman_cae_encode_many(network.cae.get(), &image, 1, 1, &latent, &chi_square) == TOLIMAN_OK)
        return;
    const std::string why = toliman_last_error(), number = "frame 0: "; // that of the frame in its batch of one
    throw Failure(kExitInput, place + ": " + (why.rfind(number, 0) == 0 ? why.substr(number.size()) : why));
}

// Why a frame seems not to be of the network's scene, "" if it seems to be. A latent without unit is not judged, only
// the chi-square.
std::string complaint_of(double latent, double chi_square, const toliman_cae_info &info) {
    if (info.cosine > 0 && std::fabs(latent) > kFarSigmas * info.crb_px)
        return formatted("a latent of %.3g px is far beyond the noise of %.3g px", latent, info.crb_px);
    if (!(std::fabs(chi_square - 1) <= kFarChiSquare))
        return formatted("a chi-square of %.3g differs from 1 +- %.3g, that of the scene's noise", chi_square,
                         kChiSquareSigma);
    return "";
}

void encode(const EncodeOptions &options, Progress &progress) {
    const Network network(options.weights);
    const toliman_cae_info &info = network.info;
    int64_t rows, cols;
    shape_of(options.shape, rows, cols);
    const bool in_pixels = info.cosine > 0; // unsupervised training leaves the latent without a unit
    // Printed together with the first line: a failure on the first frame leaves standard output empty.
    const char *head = in_pixels ? "file,frame,latent_px,chi_square\n" : "file,frame,latent,chi_square\n";
    bool far = false;
    for (const std::string &path : options.files) {
        const auto file = open_frames(path, options.dtype, static_cast<size_t>(rows), static_cast<size_t>(cols));
        FrameFile &frames = *file;
        if (frames.rows() != static_cast<size_t>(info.rows) || frames.cols() != static_cast<size_t>(info.cols))
            malformed(frames.path(), "frames of " + shape_text(frames.rows(), frames.cols()) +
                                         ": the weights are for " + shape_text(info.rows, info.cols));
        std::vector<double> pixels(frames.rows() * frames.cols()); // enough and aligned for every type
        for (size_t done = 1; frames.more(); done++) {
            const std::string place = frames.path() + ": frame " + std::to_string(done - 1);
            double latent, chi_square;
            encode_next(network, frames, pixels.data(), place, latent, chi_square);
            const std::string complaint = far ? "" : complaint_of(latent, chi_square, info);
            if (!complaint.empty()) {
                far = true;
                progress.warn(formatted("%s: %s: is this frame of the network's scene, pointing and exposure?%s",
                                        place.c_str(), complaint.c_str(), other_width(options, frames).c_str()));
            }
            print_stdout(formatted("%s%s,%zu,%.17g,%.6g\n", std::exchange(head, ""), path.c_str(), done - 1, latent,
                                   chi_square));
            if (frames.counted())
                progress.show("encode", static_cast<double>(done) / static_cast<double>(frames.count()));
            else
                progress.note("encode", std::to_string(done) + " frames");
            stop_if_asked();
        }
    }
}

} // namespace

void add_encode(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "encode");
    auto options = std::make_shared<EncodeOptions>();
    add_option(command, "--weights", options->weights, "FILE", "weights file of `toliman train`")->required();
    add_choice(command, "--dtype", options->dtype, dtypes(),
               "pixel type of files without header: u16le, u32le, i16le, f32le, or big-endian u16be, u32be, "
               "i16be, f32be");
    add_option(command, "--shape", options->shape, "ROWSxCOLS",
               "size of the frames in files without header: ROWSxCOLS");
    add_option(command, "FRAMES", options->files, "",
               ".npy and FITS files, or files without header with --dtype and --shape; - reads standard input")
        ->required();
    set_action(*command, context, options, encode);
}

} // namespace cli
