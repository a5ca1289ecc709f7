// toliman convert: FITS to .npy and back.
#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/output.hpp"
#include "common/suffix.hpp"
#include "frames/frames_in.hpp"
#include "frames/frames_out.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct Options {
    std::string in, out;
};

constexpr char kDescription[] = R"(Convert an image or a cube between FITS and .npy, as float64.

Examples:
  toliman convert mask.fits mask.npy      a scene names .npy files only
  toliman convert psf.npy psf.fits

Of a FITS file the first image is read, tiles compressed by fpack included (.fits.fz). Blank and NaN pixels are errors.)";

void convert(const Options &options, Progress &progress) {
    if (!ends_with(options.in, ".npy") && !is_fits(options.in))
        throw Failure(kExitUsage,
                      "IN " + options.in + ": must end in .npy, .fits or .fits.fz" + kind_remark(options.in));
    if (options.out != "-" && !ends_with(options.out, ".npy") && !ends_with(options.out, ".fits"))
        throw Failure(kExitUsage, "OUT " + options.out + ": must end in .npy or .fits, or be - for .npy on stdout");
    check_apart(options.out, {options.in});
    const auto in = open_frames(options.in);
    const auto out = image_output(options.out, in->axes());
    std::vector<double> image(in->rows() * in->cols());
    for (size_t k = 0; k < in->count(); k++) {
        in->read(image.data());
        out->write(image.data(), 1);
        progress.show("convert", static_cast<double>(k + 1) / static_cast<double>(in->count()));
        stop_if_asked();
    }
    out->commit();
}

} // namespace

void add_convert(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("convert", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("IN", options->in, "the .npy or FITS file to read")->required();
    command->add_option("OUT", options->out, "the .npy or .fits file to write; - is .npy on standard output")
        ->required();
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            convert(*options, progress);
        };
    });
}

} // namespace cli
